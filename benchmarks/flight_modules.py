"""Flight module of each part that can be exported, with the wheel of Carrara and Kuga's table."""

import gyrostat as gs
from gyrostat.control import AttitudePID, CurrentMode, EstimatingCompensator
from gyrostat.estimation import FrictionScaleFilter
from gyrostat.exports import CompensatedWheel, scenario_controller, targets
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

PERIOD = 0.1  # s
WHEEL = Wheel(1.5e-3, 0.0228, Stribeck(4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879))
LAW = AttitudePID(0.0571, 0.00234, 0.3126)


def compensator():
    """Compensator with its filter of the wheel's friction."""
    return EstimatingCompensator.tune(LAW, WHEEL, 0.495, 0.5, PERIOD, delay=1)


def of_scenario(path):
    """Flight module of the controller of a scenario."""
    return scenario_controller(gs.read_scenario(path), "hold")


PARTS = {
    "compensator": lambda: targets.compensator(compensator(), PERIOD),
    "controller": lambda: targets.controller(CurrentMode(LAW, WHEEL.motor_constant), PERIOD),
    "estimator": lambda: targets.estimator(FrictionScaleFilter(WHEEL, 0.5, 1e-3), PERIOD),
    "wheel": lambda: targets.wheel(WHEEL, PERIOD),
    "compensated-wheel": lambda: targets.compensated_wheel(
        CompensatedWheel(compensator(), WHEEL), PERIOD
    ),
}
"""Part, as the command line names it -> flight module."""

"""Controllers of the loop, from a measurement to a command, and what they are designed with."""

from gyrostat.control.allocation import LeastLargest, PseudoInverse
from gyrostat.control.attitude_pid import AttitudePID, CurrentMode
from gyrostat.control.attitude_regulator import AttitudeRegulator
from gyrostat.control.boresight import BoresightLaw, WheelMap, governed
from gyrostat.control.command import CurrentCommand
from gyrostat.control.conditioned_compensator import ConditionedCompensator
from gyrostat.control.controllability import Controllability, uncontrollable
from gyrostat.control.estimated_control import EstimatedControl
from gyrostat.control.estimating_compensator import EstimatingCompensator
from gyrostat.control.factorisations import EulerCube, MRPBody, QuaternionBody
from gyrostat.control.friction_feed_forward import FrictionFeedForward
from gyrostat.control.friction_filter_feed_forward import FrictionFilterFeedForward
from gyrostat.control.frit import (
    FirstOrderLags,
    LeastSquares,
    OnlineFrit,
    SampledModel,
    recursive_least_squares,
)
from gyrostat.control.guarded import Guarded
from gyrostat.control.lqr import FeedbackCommand, LinearQuadratic, lqr
from gyrostat.control.measurement_guard import FieldLimits, MeasurementGuard, SampleStatus
from gyrostat.control.model_compensator import DynamicModelCompensator
from gyrostat.control.model_error_compensator import (
    Compensation,
    Integrators,
    Law,
    ModelErrorCompensator,
)
from gyrostat.control.momentum_control import (
    FrictionScaleControl,
    FrictionTorqueControl,
    MomentumCommand,
    ProportionalMomentumControl,
)
from gyrostat.control.momentum_management import MomentumManagement
from gyrostat.control.null_space import NullSpaceControl
from gyrostat.control.output_zeroing import OutputZeroing, ZeroingCommand
from gyrostat.control.recovery import (
    MomentumRecovery,
    OneWheelRecovery,
    TwoWheelSweeps,
    ZeroMomentumRecovery,
)
from gyrostat.control.riccati import RiccatiSolution, lyapunov, riccati
from gyrostat.control.safe_frit import SafeFrit
from gyrostat.control.speed_mode import SpeedMode
from gyrostat.control.state_dependent import StateDependentRiccati
from gyrostat.control.three_axis_law import ThreeAxisLaw
from gyrostat.control.two_wheel_law import TwoWheelLaw
from gyrostat.control.two_wheel_pointing import PointingCommand, TwoWheelPointing
from gyrostat.control.wheel_array_control import (
    ArrayCommand,
    AttitudeTargets,
    WheelArrayControl,
)
from gyrostat.control.wheel_rate_loop import WheelRateLoop
from gyrostat.control.wheel_speed_loops import WheelSpeedLoops
from gyrostat.control.wheel_watch import WheelWatch

__all__ = [
    "ArrayCommand",
    "AttitudePID",
    "AttitudeRegulator",
    "AttitudeTargets",
    "BoresightLaw",
    "Compensation",
    "ConditionedCompensator",
    "Controllability",
    "CurrentCommand",
    "CurrentMode",
    "DynamicModelCompensator",
    "EstimatedControl",
    "EstimatingCompensator",
    "EulerCube",
    "FeedbackCommand",
    "FieldLimits",
    "FirstOrderLags",
    "FrictionFeedForward",
    "FrictionFilterFeedForward",
    "FrictionScaleControl",
    "FrictionTorqueControl",
    "Guarded",
    "Integrators",
    "Law",
    "LeastLargest",
    "LeastSquares",
    "LinearQuadratic",
    "MRPBody",
    "MeasurementGuard",
    "ModelErrorCompensator",
    "MomentumCommand",
    "MomentumManagement",
    "MomentumRecovery",
    "NullSpaceControl",
    "OneWheelRecovery",
    "OnlineFrit",
    "OutputZeroing",
    "PointingCommand",
    "ProportionalMomentumControl",
    "PseudoInverse",
    "QuaternionBody",
    "RiccatiSolution",
    "SafeFrit",
    "SampleStatus",
    "SampledModel",
    "SpeedMode",
    "StateDependentRiccati",
    "ThreeAxisLaw",
    "TwoWheelLaw",
    "TwoWheelPointing",
    "TwoWheelSweeps",
    "WheelArrayControl",
    "WheelMap",
    "WheelRateLoop",
    "WheelSpeedLoops",
    "WheelWatch",
    "ZeroMomentumRecovery",
    "ZeroingCommand",
    "governed",
    "lqr",
    "lyapunov",
    "recursive_least_squares",
    "riccati",
    "uncontrollable",
]

"""Controllers of the control loop, from measurement to command, and their design methods."""

from gyrostat.control.adaptive.conditioned_compensator import ConditionedCompensator
from gyrostat.control.adaptive.frit import (
    FirstOrderLags,
    LeastSquares,
    OnlineFrit,
    SampledModel,
    recursive_least_squares,
)
from gyrostat.control.adaptive.model_error_compensator import (
    Compensation,
    Integrators,
    Law,
    ModelErrorCompensator,
)
from gyrostat.control.adaptive.safe_frit import SafeFrit
from gyrostat.control.allocation.allocation import MinimaxAllocation, PseudoInverse
from gyrostat.control.allocation.momentum_unloading import MomentumUnloading
from gyrostat.control.allocation.null_space import NullSpaceControl
from gyrostat.control.allocation.wheel_fault_detector import WheelFaultDetector
from gyrostat.control.allocation.wheel_wear import WheelWear
from gyrostat.control.attitude.attitude_pid import AttitudePID, CurrentMode
from gyrostat.control.attitude.attitude_regulator import AttitudeRegulator
from gyrostat.control.attitude.attitude_targets import AttitudeTargets
from gyrostat.control.attitude.command import CurrentCommand
from gyrostat.control.attitude.output_feedback import OutputFeedback
from gyrostat.control.attitude.sun_pointing import SunPointing
from gyrostat.control.attitude.three_axis_law import ThreeAxisLaw
from gyrostat.control.attitude.wheel_array_control import ArrayCommand, WheelArrayControl
from gyrostat.control.attitude.wheel_rate_loop import WheelRateLoop
from gyrostat.control.attitude.wheel_speed_loops import WheelSpeedLoops
from gyrostat.control.design.controllability import Controllability, uncontrollable
from gyrostat.control.design.factorisations import EulerCube, MRPBody, QuaternionBody
from gyrostat.control.design.lqr import FeedbackCommand, LinearQuadratic, lqr
from gyrostat.control.design.riccati import RiccatiSolution, lyapunov, riccati
from gyrostat.control.design.state_dependent import StateDependentRiccati
from gyrostat.control.friction.estimating_compensator import EstimatingCompensator
from gyrostat.control.friction.estimating_feed_forward import EstimatingFeedForward
from gyrostat.control.friction.friction_feed_forward import FrictionFeedForward
from gyrostat.control.friction.friction_filter_feed_forward import FrictionFilterFeedForward
from gyrostat.control.friction.model_compensator import DynamicModelCompensator
from gyrostat.control.friction.momentum_control import (
    FrictionScaleControl,
    FrictionTorqueControl,
    MomentumCommand,
    ProportionalMomentumControl,
)
from gyrostat.control.friction.speed_mode import SpeedMode
from gyrostat.control.guarded import Guarded
from gyrostat.control.magnetic.b_cross import BCross, RodCommand
from gyrostat.control.magnetic.rod_unloading import RodUnloading
from gyrostat.control.measurement_guard import FieldLimits, MeasurementGuard, SampleStatus
from gyrostat.control.thruster_unloading import ThrusterUnloading
from gyrostat.control.underactuated.boresight import BoresightLaw, WheelMap, governed
from gyrostat.control.underactuated.output_zeroing import OutputZeroing, ZeroingCommand
from gyrostat.control.underactuated.recovery import (
    MomentumRecovery,
    OneWheelRecovery,
    PaddleRecovery,
    TwoWheelSweeps,
    ZeroMomentumRecovery,
)
from gyrostat.control.underactuated.two_wheel_law import TwoWheelLaw
from gyrostat.control.underactuated.two_wheel_pointing import PointingCommand, TwoWheelPointing

__all__ = [
    "ArrayCommand",
    "AttitudePID",
    "AttitudeRegulator",
    "AttitudeTargets",
    "BCross",
    "BoresightLaw",
    "Compensation",
    "ConditionedCompensator",
    "Controllability",
    "CurrentCommand",
    "CurrentMode",
    "DynamicModelCompensator",
    "EstimatingCompensator",
    "EstimatingFeedForward",
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
    "LeastSquares",
    "LinearQuadratic",
    "MRPBody",
    "MeasurementGuard",
    "MinimaxAllocation",
    "ModelErrorCompensator",
    "MomentumCommand",
    "MomentumRecovery",
    "MomentumUnloading",
    "NullSpaceControl",
    "OneWheelRecovery",
    "OnlineFrit",
    "OutputFeedback",
    "OutputZeroing",
    "PaddleRecovery",
    "PointingCommand",
    "ProportionalMomentumControl",
    "PseudoInverse",
    "QuaternionBody",
    "RiccatiSolution",
    "RodCommand",
    "RodUnloading",
    "SafeFrit",
    "SampleStatus",
    "SampledModel",
    "SpeedMode",
    "StateDependentRiccati",
    "SunPointing",
    "ThreeAxisLaw",
    "ThrusterUnloading",
    "TwoWheelLaw",
    "TwoWheelPointing",
    "TwoWheelSweeps",
    "WheelArrayControl",
    "WheelFaultDetector",
    "WheelMap",
    "WheelRateLoop",
    "WheelSpeedLoops",
    "WheelWear",
    "ZeroMomentumRecovery",
    "ZeroingCommand",
    "governed",
    "lqr",
    "lyapunov",
    "recursive_least_squares",
    "riccati",
    "uncontrollable",
]

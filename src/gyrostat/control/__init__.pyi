"""Public names of the package; `__init__.py` reads this file."""

from gyrostat.control.adaptive.conditioned_compensator import (
    ConditionedCompensator as ConditionedCompensator,
)
from gyrostat.control.adaptive.frit import FirstOrderLags as FirstOrderLags
from gyrostat.control.adaptive.frit import LeastSquares as LeastSquares
from gyrostat.control.adaptive.frit import OnlineFrit as OnlineFrit
from gyrostat.control.adaptive.frit import SampledModel as SampledModel
from gyrostat.control.adaptive.frit import recursive_least_squares as recursive_least_squares
from gyrostat.control.adaptive.model_error_compensator import Compensation as Compensation
from gyrostat.control.adaptive.model_error_compensator import Integrators as Integrators
from gyrostat.control.adaptive.model_error_compensator import Law as Law
from gyrostat.control.adaptive.model_error_compensator import (
    ModelErrorCompensator as ModelErrorCompensator,
)
from gyrostat.control.adaptive.safe_frit import SafeFrit as SafeFrit
from gyrostat.control.allocation.allocation import MinimaxAllocation as MinimaxAllocation
from gyrostat.control.allocation.allocation import PseudoInverse as PseudoInverse
from gyrostat.control.allocation.momentum_plan import MomentumPlan as MomentumPlan
from gyrostat.control.allocation.momentum_unloading import MomentumUnloading as MomentumUnloading
from gyrostat.control.allocation.null_space import NullSpaceControl as NullSpaceControl
from gyrostat.control.allocation.wheel_fault_detector import (
    WheelFaultDetector as WheelFaultDetector,
)
from gyrostat.control.allocation.wheel_wear import WheelWear as WheelWear
from gyrostat.control.attitude.attitude_pid import AttitudePID as AttitudePID
from gyrostat.control.attitude.attitude_pid import CurrentMode as CurrentMode
from gyrostat.control.attitude.attitude_regulator import AttitudeRegulator as AttitudeRegulator
from gyrostat.control.attitude.attitude_targets import AttitudeTargets as AttitudeTargets
from gyrostat.control.attitude.command import CurrentCommand as CurrentCommand
from gyrostat.control.attitude.output_feedback import OutputFeedback as OutputFeedback
from gyrostat.control.attitude.sun_pointing import SunPointing as SunPointing
from gyrostat.control.attitude.three_axis_law import ThreeAxisLaw as ThreeAxisLaw
from gyrostat.control.attitude.wheel_array_control import ArrayCommand as ArrayCommand
from gyrostat.control.attitude.wheel_array_control import WheelArrayControl as WheelArrayControl
from gyrostat.control.attitude.wheel_rate_loop import WheelRateLoop as WheelRateLoop
from gyrostat.control.attitude.wheel_speed_loops import WheelSpeedLoops as WheelSpeedLoops
from gyrostat.control.design.controllability import Controllability as Controllability
from gyrostat.control.design.controllability import uncontrollable as uncontrollable
from gyrostat.control.design.factorisations import EulerCube as EulerCube
from gyrostat.control.design.factorisations import MRPBody as MRPBody
from gyrostat.control.design.factorisations import QuaternionBody as QuaternionBody
from gyrostat.control.design.lqr import FeedbackCommand as FeedbackCommand
from gyrostat.control.design.lqr import LinearQuadratic as LinearQuadratic
from gyrostat.control.design.lqr import lqr as lqr
from gyrostat.control.design.riccati import RiccatiSolution as RiccatiSolution
from gyrostat.control.design.riccati import lyapunov as lyapunov
from gyrostat.control.design.riccati import riccati as riccati
from gyrostat.control.design.state_dependent import StateDependentRiccati as StateDependentRiccati
from gyrostat.control.friction.estimating_compensator import (
    EstimatingCompensator as EstimatingCompensator,
)
from gyrostat.control.friction.estimating_feed_forward import (
    EstimatingFeedForward as EstimatingFeedForward,
)
from gyrostat.control.friction.friction_feed_forward import (
    FrictionFeedForward as FrictionFeedForward,
)
from gyrostat.control.friction.friction_filter_feed_forward import (
    FrictionFilterFeedForward as FrictionFilterFeedForward,
)
from gyrostat.control.friction.model_compensator import (
    DynamicModelCompensator as DynamicModelCompensator,
)
from gyrostat.control.friction.momentum_control import FrictionScaleControl as FrictionScaleControl
from gyrostat.control.friction.momentum_control import (
    FrictionTorqueControl as FrictionTorqueControl,
)
from gyrostat.control.friction.momentum_control import MomentumCommand as MomentumCommand
from gyrostat.control.friction.momentum_control import (
    ProportionalMomentumControl as ProportionalMomentumControl,
)
from gyrostat.control.friction.speed_mode import SpeedMode as SpeedMode
from gyrostat.control.guarded import Guarded as Guarded
from gyrostat.control.magnetic.b_cross import BCross as BCross
from gyrostat.control.magnetic.b_cross import RodCommand as RodCommand
from gyrostat.control.magnetic.rod_unloading import RodUnloading as RodUnloading
from gyrostat.control.measurement_guard import FieldLimits as FieldLimits
from gyrostat.control.measurement_guard import MeasurementGuard as MeasurementGuard
from gyrostat.control.measurement_guard import SampleStatus as SampleStatus
from gyrostat.control.thruster_unloading import ThrusterUnloading as ThrusterUnloading
from gyrostat.control.underactuated.boresight import BoresightLaw as BoresightLaw
from gyrostat.control.underactuated.boresight import WheelMap as WheelMap
from gyrostat.control.underactuated.boresight import governed as governed
from gyrostat.control.underactuated.output_zeroing import OutputZeroing as OutputZeroing
from gyrostat.control.underactuated.output_zeroing import ZeroingCommand as ZeroingCommand
from gyrostat.control.underactuated.recovery.momentum import MomentumRecovery as MomentumRecovery
from gyrostat.control.underactuated.recovery.one_wheel import OneWheelRecovery as OneWheelRecovery
from gyrostat.control.underactuated.recovery.paddle_recovery import PaddleRecovery as PaddleRecovery
from gyrostat.control.underactuated.recovery.two_wheel_sweeps import (
    TwoWheelSweeps as TwoWheelSweeps,
)
from gyrostat.control.underactuated.recovery.zero_momentum import (
    ZeroMomentumRecovery as ZeroMomentumRecovery,
)
from gyrostat.control.underactuated.two_wheel_law import TwoWheelLaw as TwoWheelLaw
from gyrostat.control.underactuated.two_wheel_pointing import PointingCommand as PointingCommand
from gyrostat.control.underactuated.two_wheel_pointing import TwoWheelPointing as TwoWheelPointing

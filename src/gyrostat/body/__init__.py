"""What carries the wheels, and how its motion is measured."""

from gyrostat.body import rotations
from gyrostat.body.attitude_sensors import (
    StarTracker,
    TrackerGyroMeasurement,
    TrackerGyroSensors,
)
from gyrostat.body.bench_wheel import (
    BenchRecord,
    BenchWheel,
    BenchWheelState,
    MomentumMeasurement,
    MomentumSensor,
    TorqueCommand,
)
from gyrostat.body.driven_gyrostat import DrivenGyrostat
from gyrostat.body.environment import CircularOrbit, GravityGradient, HarmonicTorque
from gyrostat.body.failures import WheelFailures
from gyrostat.body.friction_steps import FrictionSteps
from gyrostat.body.gyro import Gyro, TableMeasurement, TableSensors, TrueTurn, Turn
from gyrostat.body.gyrostat import (
    Gyrostat,
    GyrostatRecord,
    GyrostatState,
    WheelTorqueCommand,
)
from gyrostat.body.imbalance import (
    Imbalance,
    ImbalancedGyrostat,
    ImbalancedRecord,
    ImbalancedState,
)
from gyrostat.body.rate_gyro import BodyMotion, RateGyro, integrated_rate
from gyrostat.body.reduced_gyrostat import (
    ReducedGyrostat,
    ReducedRecord,
    ReducedSensor,
    ReducedState,
)
from gyrostat.body.rotations import EulerAngles
from gyrostat.body.sensor_faults import FaultySensor, SensorFault
from gyrostat.body.spacecraft import Spacecraft, check_inertia
from gyrostat.body.spacecraft_file import SpacecraftFile, read_spacecraft
from gyrostat.body.spacecraft_sensor import SpacecraftMeasurement, SpacecraftSensor
from gyrostat.body.speed_driven import (
    SinusoidalMomentum,
    SpeedDrivenRecord,
    SpeedDrivenSpacecraft,
    WheelSpeedCommand,
    unit_quaternion,
)
from gyrostat.body.speed_loop import SpeedLoopRecord, SpeedLoopSpacecraft, SpeedLoopState
from gyrostat.body.table import AirBearingTable, DriveRecord, TableCommand, TableState
from gyrostat.body.torque_driven import (
    BodyRateRecord,
    BodyTorqueCommand,
    EulerMeasurement,
    EulerSensor,
    EulerState,
    TorqueDrivenBody,
)

__all__ = [
    "AirBearingTable",
    "BenchRecord",
    "BenchWheel",
    "BenchWheelState",
    "BodyMotion",
    "BodyRateRecord",
    "BodyTorqueCommand",
    "CircularOrbit",
    "DriveRecord",
    "DrivenGyrostat",
    "EulerAngles",
    "EulerMeasurement",
    "EulerSensor",
    "EulerState",
    "FaultySensor",
    "FrictionSteps",
    "GravityGradient",
    "Gyro",
    "Gyrostat",
    "GyrostatRecord",
    "GyrostatState",
    "HarmonicTorque",
    "Imbalance",
    "ImbalancedGyrostat",
    "ImbalancedRecord",
    "ImbalancedState",
    "MomentumMeasurement",
    "MomentumSensor",
    "RateGyro",
    "ReducedGyrostat",
    "ReducedRecord",
    "ReducedSensor",
    "ReducedState",
    "SensorFault",
    "SinusoidalMomentum",
    "Spacecraft",
    "SpacecraftFile",
    "SpacecraftMeasurement",
    "SpacecraftSensor",
    "SpeedDrivenRecord",
    "SpeedDrivenSpacecraft",
    "SpeedLoopRecord",
    "SpeedLoopSpacecraft",
    "SpeedLoopState",
    "StarTracker",
    "TableCommand",
    "TableMeasurement",
    "TableSensors",
    "TableState",
    "TorqueCommand",
    "TorqueDrivenBody",
    "TrackerGyroMeasurement",
    "TrackerGyroSensors",
    "TrueTurn",
    "Turn",
    "WheelFailures",
    "WheelSpeedCommand",
    "WheelTorqueCommand",
    "check_inertia",
    "integrated_rate",
    "read_spacecraft",
    "rotations",
    "unit_quaternion",
]

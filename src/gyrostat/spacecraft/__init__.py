"""Bodies with reaction wheels, their sensors, failures and environment."""

from gyrostat.spacecraft.actuators.thrusters import Thrusters
from gyrostat.spacecraft.actuators.torque_rods import TorqueRods
from gyrostat.spacecraft.added_sensors import AddedSensor, AddedSensors
from gyrostat.spacecraft.attitude_sensors import (
    StarTracker,
    TrackerGyroMeasurement,
    TrackerGyroSensors,
    TrackerMeasurement,
)
from gyrostat.spacecraft.driven_gyrostat import DrivenGyrostat
from gyrostat.spacecraft.environment import CircularOrbit, GravityGradient, HarmonicTorque
from gyrostat.spacecraft.failures import WheelFailures
from gyrostat.spacecraft.flexible.appendages import hinged_panel, spring_mass
from gyrostat.spacecraft.flexible.modes import FlexibleModes
from gyrostat.spacecraft.friction_steps import FrictionSteps
from gyrostat.spacecraft.gyro import Gyro, TableMeasurement, TableSensors, TrueTurn, Turn
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.gyrostat_state import (
    GyrostatRecord,
    GyrostatState,
    RateRecord,
    WheelTorqueCommand,
)
from gyrostat.spacecraft.imbalance import Imbalance, ImbalancedGyrostat
from gyrostat.spacecraft.paddle_gyrostat import PaddleAngle, PaddleGyrostat
from gyrostat.spacecraft.plant_changes import Change, ChangingPlant, PlantChange
from gyrostat.spacecraft.rate_gyro import BodyMotion, RateGyro, integrated_rate
from gyrostat.spacecraft.sensor_faults import FaultySensor, SensorFault
from gyrostat.spacecraft.sensors.magnetometer import Magnetometer
from gyrostat.spacecraft.sensors.position_sensor import PositionSensor
from gyrostat.spacecraft.sensors.sampled import InstantSensor, Sampled
from gyrostat.spacecraft.sensors.star_tracker_heads import StarTrackerHead, StarTrackerHeads
from gyrostat.spacecraft.sensors.sun_sensor import CoarseSunSensors, SunSensor
from gyrostat.spacecraft.spacecraft import Spacecraft, check_inertia
from gyrostat.spacecraft.spacecraft_file import SpacecraftFile, read_spacecraft
from gyrostat.spacecraft.spacecraft_sensor import SpacecraftMeasurement, SpacecraftSensor
from gyrostat.spacecraft.speed_driven import (
    SinusoidalMomentum,
    SpeedDrivenSpacecraft,
    WheelSpeedCommand,
    unit_quaternion,
)
from gyrostat.spacecraft.speed_loop import SpeedLoopSpacecraft, SpeedLoopState
from gyrostat.spacecraft.table import AirBearingTable, DriveRecord, TableCommand, TableState
from gyrostat.spacecraft.torque_models import Actuator, TorqueModel
from gyrostat.spacecraft.torques.aerodynamic import AerodynamicTorque
from gyrostat.spacecraft.torques.residual_dipole import ResidualDipole
from gyrostat.spacecraft.torques.solar_pressure import SolarPressureTorque
from gyrostat.spacecraft.torques.surfaces import Surfaces
from gyrostat.spacecraft.wheel_harmonics import WheelHarmonics, WheelStructure

__all__ = [
    "Actuator",
    "AddedSensor",
    "AddedSensors",
    "AerodynamicTorque",
    "AirBearingTable",
    "BodyMotion",
    "Change",
    "ChangingPlant",
    "CircularOrbit",
    "CoarseSunSensors",
    "DriveRecord",
    "DrivenGyrostat",
    "FaultySensor",
    "FlexibleModes",
    "FrictionSteps",
    "GravityGradient",
    "Gyro",
    "Gyrostat",
    "GyrostatRecord",
    "GyrostatState",
    "HarmonicTorque",
    "Imbalance",
    "ImbalancedGyrostat",
    "InstantSensor",
    "Magnetometer",
    "PaddleAngle",
    "PaddleGyrostat",
    "PlantChange",
    "PositionSensor",
    "RateGyro",
    "RateRecord",
    "ResidualDipole",
    "Sampled",
    "SensorFault",
    "SinusoidalMomentum",
    "SolarPressureTorque",
    "Spacecraft",
    "SpacecraftFile",
    "SpacecraftMeasurement",
    "SpacecraftSensor",
    "SpeedDrivenSpacecraft",
    "SpeedLoopSpacecraft",
    "SpeedLoopState",
    "StarTracker",
    "StarTrackerHead",
    "StarTrackerHeads",
    "SunSensor",
    "Surfaces",
    "TableCommand",
    "TableMeasurement",
    "TableSensors",
    "TableState",
    "Thrusters",
    "TorqueModel",
    "TorqueRods",
    "TrackerGyroMeasurement",
    "TrackerGyroSensors",
    "TrackerMeasurement",
    "TrueTurn",
    "Turn",
    "WheelFailures",
    "WheelHarmonics",
    "WheelSpeedCommand",
    "WheelStructure",
    "WheelTorqueCommand",
    "check_inertia",
    "hinged_panel",
    "integrated_rate",
    "read_spacecraft",
    "spring_mass",
    "unit_quaternion",
]

"""Public names of gyrostat and the rooms that have them; `__init__.py` reads this file."""

from gyrostat.campaigns.scenario_file import read_scenario as read_scenario
from gyrostat.control import AttitudePID as AttitudePID
from gyrostat.control import CurrentMode as CurrentMode
from gyrostat.control import EstimatingCompensator as EstimatingCompensator
from gyrostat.control import SpeedMode as SpeedMode
from gyrostat.control import TwoWheelPointing as TwoWheelPointing
from gyrostat.control import WheelArrayControl as WheelArrayControl
from gyrostat.core.errors import InputError as InputError
from gyrostat.estimation import AttitudeFilter as AttitudeFilter
from gyrostat.estimation import FrictionScaleFilter as FrictionScaleFilter
from gyrostat.estimation import track_friction as track_friction
from gyrostat.simulation import simulate_loop as simulate_loop
from gyrostat.spacecraft import AirBearingTable as AirBearingTable
from gyrostat.spacecraft import Gyro as Gyro
from gyrostat.spacecraft import Gyrostat as Gyrostat
from gyrostat.spacecraft import RateGyro as RateGyro
from gyrostat.spacecraft import SensorFault as SensorFault
from gyrostat.spacecraft import Spacecraft as Spacecraft
from gyrostat.spacecraft import SpacecraftSensor as SpacecraftSensor
from gyrostat.spacecraft import StarTracker as StarTracker
from gyrostat.spacecraft import TableSensors as TableSensors
from gyrostat.spacecraft import WheelFailures as WheelFailures
from gyrostat.spacecraft import read_spacecraft as read_spacecraft
from gyrostat.telemetry import read_record as read_record
from gyrostat.verbs import bench as bench
from gyrostat.verbs import campaign as campaign
from gyrostat.verbs import export as export
from gyrostat.verbs import feasible as feasible
from gyrostat.verbs import identify as identify
from gyrostat.verbs import recover as recover
from gyrostat.verbs import replay as replay
from gyrostat.verbs import report as report
from gyrostat.verbs import reproduce as reproduce
from gyrostat.verbs import simulate as simulate
from gyrostat.verbs import validate as validate
from gyrostat.wheel import Driver as Driver
from gyrostat.wheel import Tachometer as Tachometer
from gyrostat.wheel import Wheel as Wheel
from gyrostat.wheel import WheelArray as WheelArray
from gyrostat.wheel import read_model as read_model
from gyrostat.wheel.friction import DirectionalStribeck as DirectionalStribeck
from gyrostat.wheel.friction import LuGre as LuGre
from gyrostat.wheel.friction import Stribeck as Stribeck
from gyrostat.wheel.friction import ViscousCoulomb as ViscousCoulomb

__version__: str

"""Filters and observers that run in a control loop, with a fixed computing effort per sample."""

from gyrostat.estimation.attitude_filter import AttitudeEstimate, AttitudeFilter
from gyrostat.estimation.friction_scale import FrictionScaleEstimate, FrictionScaleFilter
from gyrostat.estimation.friction_torque import FrictionTorqueEstimate, FrictionTorqueFilter
from gyrostat.estimation.momentum_attitude_filter import (
    MomentumAttitudeEstimate,
    MomentumAttitudeFilter,
)
from gyrostat.estimation.rate_observer import RateEstimate, RateObserver
from gyrostat.estimation.rotor_scale import RotorScaleEstimate, RotorScaleFilter
from gyrostat.estimation.steady_attitude_filter import SteadyAttitudeEstimate, SteadyAttitudeFilter
from gyrostat.estimation.torque_walk import TorqueWalk
from gyrostat.estimation.track import FrictionTrack, track_friction
from gyrostat.estimation.wheel_array_momentum import WheelArrayEstimate, WheelArrayFilter
from gyrostat.estimation.wheel_momentum import (
    MomentumEstimate,
    MomentumFilter,
    WheelMomentumFilter,
)

__all__ = [
    "AttitudeEstimate",
    "AttitudeFilter",
    "FrictionScaleEstimate",
    "FrictionScaleFilter",
    "FrictionTorqueEstimate",
    "FrictionTorqueFilter",
    "FrictionTrack",
    "MomentumAttitudeEstimate",
    "MomentumAttitudeFilter",
    "MomentumEstimate",
    "MomentumFilter",
    "RateEstimate",
    "RateObserver",
    "RotorScaleEstimate",
    "RotorScaleFilter",
    "SteadyAttitudeEstimate",
    "SteadyAttitudeFilter",
    "TorqueWalk",
    "WheelArrayEstimate",
    "WheelArrayFilter",
    "WheelMomentumFilter",
    "track_friction",
]

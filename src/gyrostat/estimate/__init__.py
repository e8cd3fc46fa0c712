"""Estimators that run on line: fixed effort in every sample."""

from gyrostat.estimate.attitude_filter import AttitudeEstimate, AttitudeFilter
from gyrostat.estimate.friction_scale import FrictionScaleEstimate, FrictionScaleFilter
from gyrostat.estimate.friction_torque import FrictionTorqueEstimate, FrictionTorqueFilter
from gyrostat.estimate.rate_observer import RateEstimate, RateObserver
from gyrostat.estimate.torque_walk import TorqueWalk
from gyrostat.estimate.track import FrictionTrack, track_friction
from gyrostat.estimate.wheel_momentum import MomentumEstimate, WheelMomentumFilter

__all__ = [
    "AttitudeEstimate",
    "AttitudeFilter",
    "FrictionScaleEstimate",
    "FrictionScaleFilter",
    "FrictionTorqueEstimate",
    "FrictionTorqueFilter",
    "FrictionTrack",
    "MomentumEstimate",
    "RateEstimate",
    "RateObserver",
    "TorqueWalk",
    "WheelMomentumFilter",
    "track_friction",
]

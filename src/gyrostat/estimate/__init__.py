"""Estimators that run on line: fixed effort in every sample."""

from gyrostat.estimate.rate_observer import RateEstimate, RateObserver
from gyrostat.estimate.wheel_momentum import MomentumEstimate, WheelMomentumFilter

__all__ = ["MomentumEstimate", "RateEstimate", "RateObserver", "WheelMomentumFilter"]

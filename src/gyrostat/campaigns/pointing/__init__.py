"""Pointing budget: indices of ECSS-E-ST-60-10C, their statistics, in time and from spectra."""

from gyrostat.campaigns.pointing.spectrum import size_from_spectrum, window_gain

__all__ = ["size_from_spectrum", "window_gain"]

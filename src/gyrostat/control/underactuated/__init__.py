"""Attitude control with fewer than three working wheels."""

"""Attitude control with fewer than three working wheels."""

__all__: list[str] = []

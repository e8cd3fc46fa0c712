"""Microvibration of wheels: loads from a waterfall, and the line of sight that they move."""

__all__: list[str] = []

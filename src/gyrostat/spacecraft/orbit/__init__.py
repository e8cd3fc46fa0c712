"""Orbit of a spacecraft and what surrounds it, as tables over time."""

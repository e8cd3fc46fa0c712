"""Torques of the environment on a spacecraft in an orbit, and what they need: facets, sunlight."""

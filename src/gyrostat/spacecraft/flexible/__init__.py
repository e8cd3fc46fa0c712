"""Flexible appendages and propellant slosh of a spacecraft, as linear modes."""

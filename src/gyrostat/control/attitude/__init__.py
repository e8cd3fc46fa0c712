"""Attitude control laws for three axes, their wheel loops and their commands."""

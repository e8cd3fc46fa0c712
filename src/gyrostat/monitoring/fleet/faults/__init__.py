"""Faults of flying wheels, one file for each; `fault.py` has their base."""

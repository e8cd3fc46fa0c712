"""Actuators beside the wheels, for `Gyrostat.actuators`."""

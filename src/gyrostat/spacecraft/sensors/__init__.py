"""Sensors beside those of attitude, rate and wheel speed, for `AddedSensors`."""

"""Noise of a rate gyro from a record at rest: Allan deviations and the parameters behind them."""

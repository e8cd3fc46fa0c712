"""Least squares on the speed: problem, prediction, iteration."""

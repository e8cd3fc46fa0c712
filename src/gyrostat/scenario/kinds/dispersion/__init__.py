"""Distributions of dispersed values, one in each file."""

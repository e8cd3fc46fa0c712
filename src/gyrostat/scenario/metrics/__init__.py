"""Metrics of a scenario: their keys, names, units and meanings."""

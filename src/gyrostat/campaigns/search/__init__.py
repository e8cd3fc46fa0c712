"""Searches among the runs of a scenario: rare failures."""

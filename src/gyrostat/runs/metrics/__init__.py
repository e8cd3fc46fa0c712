"""Metrics of runs, computed sample by sample at constant memory."""

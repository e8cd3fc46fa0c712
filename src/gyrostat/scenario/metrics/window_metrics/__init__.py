"""Metrics of a window: a class in a file of this folder is a metric."""

"""Metrics of every run: a class in a file of this folder is a metric."""

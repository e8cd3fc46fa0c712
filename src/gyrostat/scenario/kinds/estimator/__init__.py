"""Kinds of [estimator]."""

"""Kinds of [[imbalance.harmonic]]."""

"""Kinds of events, one in each file."""

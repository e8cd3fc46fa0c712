"""Kinds of [[reference.slew]]."""

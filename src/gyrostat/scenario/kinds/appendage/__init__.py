"""Kinds of appendages of a spacecraft file."""

"""Kinds of [[reference.transition]] beside `conditions`."""

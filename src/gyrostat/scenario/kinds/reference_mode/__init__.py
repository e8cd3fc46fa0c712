"""Kinds of [[reference.mode]] beside those of [reference]."""

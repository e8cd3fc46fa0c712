"""Kinds of [unloading]."""

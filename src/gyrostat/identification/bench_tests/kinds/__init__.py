"""Kinds of bench tests: one file each, found by its place."""

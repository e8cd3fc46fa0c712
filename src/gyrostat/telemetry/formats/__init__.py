"""Formats of records: one file each, found by its place."""

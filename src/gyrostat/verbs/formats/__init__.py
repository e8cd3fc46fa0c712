"""Formats that `export` can write, one file each."""

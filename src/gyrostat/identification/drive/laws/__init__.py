"""Control laws of drives: one file each, found by its place."""

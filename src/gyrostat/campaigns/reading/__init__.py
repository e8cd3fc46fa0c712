"""Read scenario files."""

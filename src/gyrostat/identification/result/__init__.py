"""A fit, its text and its file."""

"""Own parts: components that a user writes in Python, from a file or as objects."""

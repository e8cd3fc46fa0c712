"""Trial of user-defined parts, before the first run."""

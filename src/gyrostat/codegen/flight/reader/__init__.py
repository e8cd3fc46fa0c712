"""Reader of emitted C: its decisions, and its evaluation for many inputs at once."""

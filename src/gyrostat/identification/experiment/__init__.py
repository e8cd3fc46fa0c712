"""Design of the next record."""

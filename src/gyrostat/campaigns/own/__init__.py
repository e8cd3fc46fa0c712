"""Earlier place of the protocols of user-defined parts."""

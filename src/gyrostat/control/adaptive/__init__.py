"""Model error compensation and its on-line tuning (FRIT)."""

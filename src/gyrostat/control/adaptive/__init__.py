"""Model error compensation and its on-line tuning (FRIT)."""

__all__: list[str] = []

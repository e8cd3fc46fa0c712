"""Riccati equations, LQR, SDRE factorisations and controllability."""

__all__: list[str] = []

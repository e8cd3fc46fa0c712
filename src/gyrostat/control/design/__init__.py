"""Riccati equations, LQR, SDRE factorisations and controllability."""

"""Identification of drives in closed loop: inverse dynamics with instruments."""

"""Endo, Sekiguchi and Nonaka: two wheels, a model error compensator tuned on line."""

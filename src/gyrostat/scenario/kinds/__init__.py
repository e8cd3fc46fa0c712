"""Components of this package that a scenario can name by their kind."""

"""Controllers that compensate or estimate the bearing friction of a wheel."""

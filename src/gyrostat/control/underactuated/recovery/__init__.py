"""Recovery laws: bring a spacecraft to rest in a target attitude with the remaining wheels."""

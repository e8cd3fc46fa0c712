"""Distribution of the parameters of a lot of wheels, with the errors of their fits taken out."""

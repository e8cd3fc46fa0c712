"""Changes of a scenario from Python, with the text of the objects that it is given."""

"""Colours of figures."""

MEASURED, MODEL, BAND, MARK = "#8a8f98", "#1f5fa8", "#9cc3ea", "#c8461e"

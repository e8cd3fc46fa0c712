"""Judgement of results: plausibility, validation, acceptance, differences between fits."""

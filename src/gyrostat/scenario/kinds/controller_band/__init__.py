"""Kinds of [[controller.band]]."""

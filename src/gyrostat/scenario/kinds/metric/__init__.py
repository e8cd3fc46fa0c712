"""Kinds of [[metric]]."""

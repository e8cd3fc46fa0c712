"""Kinds of [[keep_out]]."""

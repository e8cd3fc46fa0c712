"""Kinds of [[sensor]]."""

"""Kinds of [reference]."""

"""Kinds of [sensors]."""

"""Kinds of [orbit]."""

"""Kinds of [environment]."""

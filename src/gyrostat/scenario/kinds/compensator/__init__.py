"""Kinds of [compensator]."""

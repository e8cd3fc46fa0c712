"""Kinds of [[actuator]]."""

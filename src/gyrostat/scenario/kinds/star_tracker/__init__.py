"""Kinds of [[star_tracker]]."""

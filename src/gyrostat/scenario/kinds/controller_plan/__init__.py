"""Kinds of [[controller.plan]]."""

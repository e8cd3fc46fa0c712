"""Kinds of [[station]]."""

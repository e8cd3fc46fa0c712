"""Kinds of [controller], one file each or a few that belong together."""

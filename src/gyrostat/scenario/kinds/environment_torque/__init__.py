"""Kinds of [[environment.torque]]."""

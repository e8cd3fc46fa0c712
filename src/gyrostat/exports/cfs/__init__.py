"""Application for NASA's core Flight System (cFS) around a flight module."""

from gyrostat.exports.cfs.application import application

__all__ = ["application"]

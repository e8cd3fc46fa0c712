"""Test vectors of emitted C that show every decision and condition."""

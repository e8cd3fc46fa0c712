"""Tests that a bench runs: from a spec sheet to profiles, and from records to verdicts."""

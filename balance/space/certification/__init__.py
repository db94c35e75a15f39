"""Integers of a design space confirmed or corrected by exact arithmetic."""

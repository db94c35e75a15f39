"""Gravity balance by springs."""

"""Mobility to first and to higher order, and independent coordinates."""

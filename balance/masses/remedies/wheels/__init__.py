"""Balancing wheels on the base, driven at a varying ratio or by motors."""

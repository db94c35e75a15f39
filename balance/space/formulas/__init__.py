"""Conditions of balance as formulas in the dimensions of a planar linkage."""

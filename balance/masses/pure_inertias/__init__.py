"""Masses of equal momentum: pure inertias, and what can be built from them."""

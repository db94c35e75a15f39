"""Paths along which a linkage leaves its base at rest."""

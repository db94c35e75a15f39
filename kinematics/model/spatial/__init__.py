"""Screws, displacements and inertias in space."""

"""Shaking of linkages that are made with tolerances."""

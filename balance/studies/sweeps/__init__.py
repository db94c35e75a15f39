"""Sweeps: what a study varies, geometries that are placed and closed, and their quantities."""

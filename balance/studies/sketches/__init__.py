"""Planar linkages from sketches: points, and the links that join them."""

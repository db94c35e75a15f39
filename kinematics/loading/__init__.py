"""Linkages from files, from the gallery, and without a file."""

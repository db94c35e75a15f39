"""Duplicates: copies of a linkage that cancel its momentum."""

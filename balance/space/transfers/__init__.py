"""Inertia transfers across joints, and the part of a design space that they span."""

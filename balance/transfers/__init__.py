"""Inertia transfers: what joints let through, and the part of a design space that they span."""

"""Meaning of a design space: point masses, displacements and rods that leave it balanced."""

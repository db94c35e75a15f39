"""Masses from measured motions and loads."""

"""Motions that shake the base least, with the masses as they are."""

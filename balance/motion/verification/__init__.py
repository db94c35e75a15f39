"""Motions of a linkage, its shaking loads and joint reactions, and the verdict on balance."""

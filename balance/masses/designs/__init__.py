"""Designs that can be built: a verdict or a proof of none, optima, files with new masses."""

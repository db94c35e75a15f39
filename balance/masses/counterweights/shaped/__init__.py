"""Counterweights of a simple shape: discs, blocks and cylinders."""

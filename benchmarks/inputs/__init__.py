"""Linkages, poses and peers that several benchmarks share."""

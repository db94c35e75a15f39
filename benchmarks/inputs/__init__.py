"""Linkages and poses that several benchmarks use."""

"""Kernels: functions compiled by Numba, and the cache of compiled kernels."""

"""Synthesis: mechanisms that are balanced by design and pass through given positions."""

"""Modes of motion that meet at a pose, each with its design space and verdict."""

"""Inertial parameters of one body: conversions, and parts of them."""

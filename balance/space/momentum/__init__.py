"""Momentum as a linear function of the inertial parameters."""

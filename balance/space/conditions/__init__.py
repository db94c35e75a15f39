"""Conditions on mass distributions, order by order, and their rank."""

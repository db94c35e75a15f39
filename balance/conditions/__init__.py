"""Conditions on mass distributions: gathered order by order, and how many are independent."""

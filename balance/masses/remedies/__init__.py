"""Remedies: what is built into a linkage that no mass distribution balances, and its cost."""

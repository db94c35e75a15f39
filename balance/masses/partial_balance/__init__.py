"""Partial balance: the least shaking for a budget of added matter."""

"""Decoupling: whether the inertia of a linkage on its base is constant in every motion."""

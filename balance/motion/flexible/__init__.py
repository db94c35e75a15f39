"""Dynamic balance of flexible mechanisms: modes, supports, similar arms, simulation."""

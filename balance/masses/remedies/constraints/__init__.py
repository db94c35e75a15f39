"""Constraints: relations between inputs, and reactionless paths."""

"""What a linkage does to its base: shaking, reactions, paths, links that bend."""

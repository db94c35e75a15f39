"""Which masses balance a linkage: conditions, design spaces, proofs, explanations."""

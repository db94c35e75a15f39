"""Counter-rotations: rotors geared to joints, on links, on the base, or as counterweights."""

"""Many linkages: sweeps, searches for special geometries, synthesis."""

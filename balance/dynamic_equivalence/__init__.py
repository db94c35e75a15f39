"""Mass distributions of equal momentum: pure inertias, and masses that can be built from them."""

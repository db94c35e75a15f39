"""What all other groups use: options, tolerances, files, JSON."""

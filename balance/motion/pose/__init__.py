"""Balance in one pose: momentum matrix, velocities without reaction, bodies that balance."""

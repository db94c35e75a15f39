"""What a design space means: point masses, displacements and rods that leave it balanced."""

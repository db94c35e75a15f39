"""Taylor motions: the joints of a closed motion as polynomials in its inputs."""

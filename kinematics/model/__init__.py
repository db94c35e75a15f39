"""The linkage as data, its arrays, and the relations between its inputs."""

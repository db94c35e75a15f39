"""The linkage as data: screws, the elements of its file, arrays, relations of its inputs."""

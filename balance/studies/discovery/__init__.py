"""Search for special geometries, whose design space is larger than that of their neighbours."""

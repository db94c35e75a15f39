"""Design spaces: of one linkage, of many geometries, and how sure they are."""

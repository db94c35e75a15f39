"""Design spaces of one topology in many geometries."""

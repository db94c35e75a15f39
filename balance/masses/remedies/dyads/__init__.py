"""Added dyads: two links that relate the angles of a planar linkage."""

"""A linkage on a base that floats, or stands on springs."""

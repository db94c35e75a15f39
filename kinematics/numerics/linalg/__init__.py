"""Linear algebra, one algorithm a file: QR, null spaces, pseudo-inverse, Newton, rationals."""

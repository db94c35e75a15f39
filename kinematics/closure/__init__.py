"""Loop closure: power series at a pose, and Newton's method at finite poses."""

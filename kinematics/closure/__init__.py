"""Loop closure: power series at a pose, Newton's method at finite poses, mobility."""

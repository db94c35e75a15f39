"""Matter of limited density in regions: what parts of them it fills."""

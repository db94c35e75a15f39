"""Requirements of balance, each with a quantity and a region, and their intersection."""

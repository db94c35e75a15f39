"""Claims: one file each, named by the claim that it tests."""

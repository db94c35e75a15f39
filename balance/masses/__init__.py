"""Which masses can be built: designs, counterweights, remedies."""

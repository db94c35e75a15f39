"""Counterweights: matter that is added to given links, inside regions of their frames."""

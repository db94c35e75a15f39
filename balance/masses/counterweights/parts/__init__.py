"""Parts: counterweights as closed solids, and the files that a workshop makes them from."""

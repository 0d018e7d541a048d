"""Observations as vectors for networks: what their entries are, and who writes them."""

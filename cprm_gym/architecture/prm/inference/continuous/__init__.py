"""Mixtures of normals over states and numbers: beliefs, and the programs that take them through a slice."""

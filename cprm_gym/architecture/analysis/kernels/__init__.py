"""Compiled kernels of the analysis: packed state spaces, timed state spaces, hash table, graphs."""

"""Compiled kernels of the analysis: packed state spaces, cycle-accurate state spaces, graphs."""

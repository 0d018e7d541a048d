"""Kernels of mixtures of normals: one component, one formula, one slice, fewer components."""

"""Kernels of the scene: own pose, readings of players, who is who."""

from .....compilation import kernel_group

kernel = kernel_group(_nrt=False)

"""Compiled kernels of the environments."""

from ...compilation import kernel_group

kernel = kernel_group()

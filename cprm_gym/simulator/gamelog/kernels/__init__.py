"""Compiled kernels of game logs: numbers to text and back, whole lines at a time."""

from ....compilation import kernel_group

kernel = kernel_group()

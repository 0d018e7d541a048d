"""Kernels that the ball and the scene share: what the eye tells."""

from ....compilation import kernel_group

kernel = kernel_group(_nrt=False)

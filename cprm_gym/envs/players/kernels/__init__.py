"""Compiled decisions and memories of the players; `kernel` is their one decorator."""

from ....compilation import kernel_group

kernel = kernel_group()

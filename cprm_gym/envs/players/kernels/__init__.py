"""Compiled decisions and memories of the players; `kernel` is their one decorator."""

from pathlib import Path

from ....compilation import kernel_group

kernel = kernel_group(Path(__file__).parent)

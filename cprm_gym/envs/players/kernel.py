"""The decorator of this package's kernels."""

from pathlib import Path

from ...compilation import kernel_group

kernel = kernel_group(Path(__file__).parent)

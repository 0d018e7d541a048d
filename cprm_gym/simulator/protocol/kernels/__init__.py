"""Compiled kernels of the protocol: messages written and commands read in bulk, the same to the byte as `messages` and `commands`."""

from __future__ import annotations

from ...kernels import kernel as kernel

"""Shared test settings."""

import os

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("MPLBACKEND", "Agg")

from hypothesis import settings

settings.register_profile("cprm", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("cprm")

"""Shared test settings."""

import os
import signal

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("MPLBACKEND", "Agg")

signal.signal(signal.SIGINT, signal.default_int_handler)  # shells ignore it for what runs in the background; tests send it

from hypothesis import settings  # noqa: E402

settings.register_profile("cprm", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("cprm")

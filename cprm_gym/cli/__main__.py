"""``python -m cprm_gym.cli``."""

from . import app

app()

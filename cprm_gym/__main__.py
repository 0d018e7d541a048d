"""``python -m cprm_gym`` is the ``cprm-gym`` command."""

from .cli import app

app(prog_name="cprm-gym")

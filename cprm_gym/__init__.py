"""cprm_gym: structured, concurrent, real-time action, and 2D soccer as Gymnasium and PettingZoo environments.

Importing the package registers the environments (``gymnasium.make("cprm/GoToBall-v0")``); ``cprm_gym.envs.soccer_v0`` is the
PettingZoo module.
"""

__version__ = "0.1.0"

from .envs.registration import register_all as _register_all
from .errors import CprmError

_register_all()

__all__ = ["CprmError", "__version__"]

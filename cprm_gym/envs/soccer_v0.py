"""The PettingZoo module: ``soccer_v0.parallel_env(left=3, right=3)``, ``env`` (AEC) and ``raw_env``; see `cprm_gym.envs.soccer`."""

from .soccer import env, parallel_env, raw_env

__all__ = ["env", "parallel_env", "raw_env"]

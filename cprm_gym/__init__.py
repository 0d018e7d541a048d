"""cprm_gym: structured, concurrent, real-time action, and 2D soccer as Gymnasium and PettingZoo environments."""

__version__ = "0.1.0"

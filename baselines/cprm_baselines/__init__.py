"""Controllers to compare with: one controller, one file, all on the interface of `cprm_gym.envs.controller`."""

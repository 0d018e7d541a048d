"""Bridges to libraries of multi-agent learning, each over many worlds at once.

* `worlds`: the agents of many worlds, in groups of a side, as arrays: what all bridges hand on;
* `buffers`: rows of flat arrays that are written in place, as PufferLib wants them;
* `torchrl_env`, `benchmarl_task`, `rllib_env`: of TorchRL, BenchMARL and RLlib. Each of these modules needs its library.

That of stable-baselines3 is `cprm_gym.wrappers.sb3.SoccerVecEnv`.
"""

"""Reinforcement learning with stable-baselines3 on the environments of cprm_gym."""

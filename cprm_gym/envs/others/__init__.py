"""The players beside the agents whom controllers play: who there is (`registry`), how they are played, and leagues of earlier selves.

The option ``others`` of every environment takes their names, or factories of controllers (`cprm_gym.envs.controller.ControllerFactory`).
"""

"""What the hand-written baselines have in common: one knowledge of soccer, and a way to act with it, whatever the structure.

`sheet` computes named quantities for all worlds at once, `skill` is a skill with the thresholds and commands of the agents' own, `scene`
holds both for a task, `player` turns a structure's choice of a skill into an action. The structures (`cprm_baselines.fsm` and its
neighbours) only decide which skill runs when: that is what is compared.
"""

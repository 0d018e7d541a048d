"""The house's behaviours analysed in the simulator's world: exact, bounded and sampled side by side, and against the simulator itself."""

"""Agents and skills in the simpler architectures that ours contains: as state machines, and as belief regions."""

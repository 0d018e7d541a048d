"""Plans for eight rows at a time."""

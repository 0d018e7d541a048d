"""The player who finds a ball again that has left his view."""

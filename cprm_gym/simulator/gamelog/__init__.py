"""Game and command logs: read, written, replayed."""

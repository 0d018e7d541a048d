"""Ladders: graded opponents for each family of tasks, with ratings from a round robin that can be interrupted."""

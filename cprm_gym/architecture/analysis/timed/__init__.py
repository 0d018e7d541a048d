"""The same with clocks, priorities and an environment: the timed reachability graph."""

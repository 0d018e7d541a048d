"""From slices and readings to beliefs: filtering, smoothing, learning, and the numbers read from a belief."""

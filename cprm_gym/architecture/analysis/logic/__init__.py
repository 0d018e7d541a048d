"""What follows from what, for expressions of the one small language: by cells, by boxes, by z3 where it is installed."""

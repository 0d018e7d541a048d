"""One step of filtering as a plan of array operations, made once and run often."""

"""The cycle of a net, compiled: arrays, sets, clocks, objects, what follows from a marking, firings."""

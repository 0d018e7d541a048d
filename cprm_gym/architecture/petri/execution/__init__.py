"""How a net runs: compiled arrays, kernels, the executor of many copies, traces."""

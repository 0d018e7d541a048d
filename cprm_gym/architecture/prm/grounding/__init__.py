"""From a model and its objects to the slices of a dynamic Bayesian network."""

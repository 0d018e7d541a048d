"""Compiled percepts: kernels compute, `percepts` and the agents name what they give."""

"""A step of the belief of one agent: the plans of all its components in one call."""

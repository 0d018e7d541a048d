"""The ten outfield players of an eleven: net, model and percepts."""

"""The outfield player of a match: the attacker's net, with a place in the formation, tackles, and who covers whom."""

"""The referee: what he sees, rules and orders, one file for each kind of ruling."""

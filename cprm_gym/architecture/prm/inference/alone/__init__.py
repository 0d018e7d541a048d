"""What a bank of one agent remembers: the ways from slice to slice, and where the answers to its questions stand."""

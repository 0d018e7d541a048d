"""The keeper of keepaway: its net, what it perceives, and its numbers."""

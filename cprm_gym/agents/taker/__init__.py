"""The taker of keepaway: its net, what it perceives, and its numbers."""

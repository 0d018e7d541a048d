"""What clients are told, as text and bytes."""

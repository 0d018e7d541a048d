"""What each kind of client may say: connecting and commands."""

"""The server's texts: messages to players, commands from them."""

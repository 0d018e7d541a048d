"""Skills: behaviour modules with the standard interface, one file each (dissertation §2.2.6, §2.2.7)."""

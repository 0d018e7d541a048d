"""The hiker: out to the view and home again."""

"""The room ``watch``: a run that plays, is paused, stepped, taken back, changed and asked."""

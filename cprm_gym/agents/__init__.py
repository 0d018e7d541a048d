"""Soccer behaviours built from the architecture."""

"""Nets in files: JSON, PNML, and one reader for every format."""

"""Models in other forms: JSON, BIF, pgmpy, drawings."""

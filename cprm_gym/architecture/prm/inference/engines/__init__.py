"""The ways to carry a belief from slice to slice, behind one interface (`engine.Engine`)."""

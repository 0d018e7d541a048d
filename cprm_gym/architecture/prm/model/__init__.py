"""What a model is: domains, CPDs, classes, relations, and the checks that hold when one is written."""

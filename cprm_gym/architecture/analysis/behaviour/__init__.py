"""What is reached from one marking: state spaces, boundedness, deadlocks, liveness, coverability."""

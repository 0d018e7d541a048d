"""What a net is: places, transitions, modules, and the checks that hold when one is written."""

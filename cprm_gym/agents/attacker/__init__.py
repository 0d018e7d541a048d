"""The attacker: striker and pair against opponents, with decisions where to shoot, pass, drive the ball and wait."""

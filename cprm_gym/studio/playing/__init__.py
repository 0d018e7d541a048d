"""The room ``run``: what is to be watched is chosen, many episodes are played, results and analyses are opened."""

"""What is known of the scene, measured: the own pose and the other players."""

"""What holds for every initial marking: invariants, siphons, traps, conservation (Murata 1989)."""

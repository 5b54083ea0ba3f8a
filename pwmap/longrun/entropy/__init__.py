"""How fast laps grow: topological entropy, and where it is constant."""

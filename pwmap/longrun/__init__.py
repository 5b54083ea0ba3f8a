"""What a map does in the long run, exactly: attractors, entropy, densities, crises."""

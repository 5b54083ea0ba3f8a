"""Words, pieces and the maps themselves."""

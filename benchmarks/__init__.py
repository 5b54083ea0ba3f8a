"""What asv measures over the history: `asv run`, `asv publish`, `asv preview`."""

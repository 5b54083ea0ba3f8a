"""Pictures of motions, maps and diagrams; only here matplotlib is imported."""

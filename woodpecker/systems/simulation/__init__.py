"""From event to event: flows, guards, sections, motions, and the paths that they take."""

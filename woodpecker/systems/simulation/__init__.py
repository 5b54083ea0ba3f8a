"""Motions from event to event: flows, guards, sections, and paths with margins."""

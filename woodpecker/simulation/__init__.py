"""From event to event: flow, events, words, trajectories and returns."""

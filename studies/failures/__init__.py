"""Where methods fail: scenes, methods, verdicts and the study that brings them together."""

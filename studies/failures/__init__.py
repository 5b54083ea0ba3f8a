"""Where methods fail: scenes, methods, verdicts, and the study that combines them."""

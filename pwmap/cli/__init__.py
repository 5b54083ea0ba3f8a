"""The command ``pwmap``."""

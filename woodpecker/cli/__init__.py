"""The command ``woodpecker``."""

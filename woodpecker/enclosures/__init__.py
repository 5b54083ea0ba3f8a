"""The toy over a box of starts and parameters, with proved decisions and enclosed quantities."""

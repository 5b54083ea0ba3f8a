"""The toy over a box of starts and parameters: every decision proved, every quantity enclosed."""

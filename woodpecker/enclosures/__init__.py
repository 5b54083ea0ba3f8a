"""The toy's motion over a box of starts and parameters: decisions proved, quantities enclosed."""

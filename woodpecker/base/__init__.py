"""What everything stands on: array types, checks of input, compilation, executors."""

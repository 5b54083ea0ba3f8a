"""The foundation of the package: array types, checks of input, settings, compilation, executors."""

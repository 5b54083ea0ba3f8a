"""The cost of a digit; :mod:`studies.precision.work_precision` is the study."""

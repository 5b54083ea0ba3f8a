"""What a digit costs; :mod:`studies.precision.work_precision` is the study."""

"""What studies share; none of these files is a study."""

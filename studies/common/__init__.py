"""Code that studies share; none of these files is a study."""

"""Other programs and methods that follow the toy from the section to its next return."""

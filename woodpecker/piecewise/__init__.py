"""Maps of the line in smooth pieces: borders, orbits, continuation, search; knows no toy."""

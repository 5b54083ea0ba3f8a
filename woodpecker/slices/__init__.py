"""All orbits of a map at one parameter: borders, itineraries, jumps; what hangs on one orbit."""

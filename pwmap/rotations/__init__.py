"""Maps of two pieces with a jump: rotation numbers, tongues, families of words, their centres."""

"""Three maps of the literature, with what is published of each."""

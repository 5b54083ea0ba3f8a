"""Its place puts this folder on the path, so that the tests find their helper modules."""

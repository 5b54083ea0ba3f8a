"""How far the stable motion is from trouble, in all parameters at once."""

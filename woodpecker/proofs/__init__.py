"""Computer-assisted proofs in ball arithmetic: certificates of periodic motions of the toy."""

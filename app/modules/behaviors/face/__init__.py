"""The face: what it expresses, where its eyes look, how its mouth moves with speech."""

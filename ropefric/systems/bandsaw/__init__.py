"""A band-saw blade between its wheels: the moving string, the moving beam, torsion, resonance, measurement."""

"""A band-saw blade between its wheels: sides and speeds in, frequencies of the running blade out.

`span` is one free span with any of its parts left out, how it is held, and the moving string; `beam`
the moving stiff blade, every mode to a wanted accuracy. `saw` puts the machine together: what the blade is, which
tensions the torque makes. `resonance` says where modes meet excitations and which preload to set. `answer` are all
frequencies of a saw as a scene simulates it, with torsion, the wheels' grip and the push on its teeth that it bears,
`effects` what the scene may leave out, and what that may cost.
"""

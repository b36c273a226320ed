"""A band-saw blade between its wheels: sides and speeds in, frequencies of the running blade out.

`section` and `ends` say what blade it is and how it is held, `drive` which tensions the torque makes, `saw` puts the
machine together. `string` is the moving string, `galerkin` the moving stiff blade, `beam` its frequencies to a wanted
accuracy (`chebyshev` an independent solution), `span` one free span with any of its parts left out. `answer` are all
frequencies of a saw, with torsion and the wheels' grip; `effects` what a scene may leave out and what that may cost;
`resonance` and `campbell` where modes meet excitations; `measured` compares with measured frequencies and finds the
mounting behind them; `strain`, `inverse` the preload to set; `printed` the formulas as the paper prints them.
"""

"""Machines that live on friction between a rope, belt or blade and a wheel: their pure mechanics.

Numbers in SI come in, many cases side by side; answers of numbers go out. `effect` says what a machine may be simulated
with or without, and bounds what that matters where a solution costs nothing; `friction` is a law as a machine uses it;
`checks` refuses numbers that are none; `roots` solves many cases side by side; `fixed_centres` has the length that a
belt keeps. A folder a machine, with the scenes to start from: hoist, press, bandsaw, traction, beltdrive, line.
"""

"""The virtual test rig: recordings and whole campaigns with known truth, the same bytes for the same seed.

In: the settings of a bench, a friction law, conditions, rates of faults, a seed. Out: recordings, or the folder of a
campaign. `bench` has the settings and the measuring chain, `mechanics` what happens to the rope, `recording` what goes
wrong and one whole recording, `campaign` the plan of a campaign and its files.
"""

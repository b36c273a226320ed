"""Four virtual test rigs and drawn recordings, with campaigns: known truth, the same bytes for the same seed.

In: the settings of a bench, a friction law, conditions, rates of faults, a seed. Out: recordings, or the folder of a
campaign. `bench` has the settings, the measuring chain and the pull, `recording` the faults and one whole recording,
`campaign` the plan of a campaign and its files. The second rig shares nothing with these: `dynamics` integrates rope,
wheel and motor with rate-and-state friction or LuGre bristles, `pulls` draws such machines and finds the truth of their
motion, `strangers` has their sensor and its faults, and draws families of recordings over wide ranges, each with its
truth. `further` has a third rig, a rope of masses around a wheel, and a fourth, of many junctions, that the picker is
judged by. `stories` has no equation of motion at all: it puts recordings together piece by piece, for the picker to
learn from; `sampling` is the sensor of those, `damage` changes the lines of a file afterwards.
"""

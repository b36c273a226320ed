"""A machine in a TOML file, solved with the effects that its accuracy calls for.

In comes a scene file, out go a `Solution`, an `Explanation` or a `Sweep`.
`kind` has the declarations of a kind of scene: keys, machine, numbers, words, figures; `keys` lists its keys; `kinds/`
has one file a machine.
`scene` reads a file into a problem with its friction; `plan` decides which effects and method; `explain` gives
influence and time of each effect; `solve` answers, with the uncertainty of the friction's fit; `points` answers for
many cases at once: a `sweep` over a grid, with the table of either, or `draws` of uncertain values;
`scene_templates` are the scenes to start from, of all folders of `systems`, and the `fits/` they use.
"""

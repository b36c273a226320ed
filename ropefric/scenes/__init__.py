"""A machine in a TOML file, solved with the effects that its accuracy calls for.

In comes a scene file, out go a `Solution`, an `Explanation` or a `Sweep`.
`kind` is what a kind of scene declares: keys, machine, numbers, words, figures; `declared` lists its keys; `kinds/` has
one file a machine.
`scene` reads a file into a problem with its friction; `plan` decides which effects and method; `explain` says what each
effect is worth and what time it takes; `solve` answers, with the uncertainty of the friction's fit; `points` answers for
many cases at once: a `sweep` over a grid, with the table of either, or `draws` of what is uncertain;
`scene_templates` are the scenes to start from, of all folders of `systems`, and the `fits/` they use.
"""

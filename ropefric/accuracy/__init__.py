"""Work-precision studies: error and time of every numerical method of the package, measured.

`studies` declares the comparisons, a study a file: cases with a known answer, and methods at several settings. `study`
has what they are made of, and what follows from measured points: the front, the cheapest for an accuracy. `measure`
goes through the settings and takes the time; out come `StudyResult`s, which `report` and `plotting` show.
"""

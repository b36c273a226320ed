"""The command line: presentation only. Every number it prints comes from the library.

`app` assembles the commands, runs one and turns failures into words and exit codes; `output` is where words, JSON,
tables and progress go; `options` is what commands share: their answer, and the options that name files, folders,
quantities and processes; `lazily` puts off what a help does not need.
`commands` has the commands by subject: options, one call of the library, what is shown.
"""

"""Three papers beside what ropefric computes: each numbered equation, table and figure, with what is printed.

In comes a scene, a fit or a trial table, or the machine a paper publishes; out go rows of numbers and charts.
`paper` is what an equation, a table or a figure of a paper is, and reads a paper for a machine; `prth` has the rope on a
wheel and what its paper makes of trials, `press` the belt filter press, `saw` the band saw. Every number comes from the
library.
"""

"""Trial tables and friction laws -> fitted parameters with honest uncertainty, a verdict, lift forces, the next tests.

The fit: `problem` is the least-squares problem and solves thousands of those at once, `fit` makes it of a trial table
and searches from a few good starts; `statistics` knows scatter, covariance, identifiability and criteria,
`scatter` is the one model of scatter, `result` is what a fit hands on, with the words and rules of the verdict, and
`assembled` from what was found. `intervals` follows profiles of parameters and lift forces. `store` writes, loads and
verifies fits.
What it is worth: `compare` weighs laws against each other and picks one by how each `standing` on condition means is,
`diagnose` says why a rope does not obey the capstan equation. What it is for: `predict` carries it to a wheel, and
to simulators and lmfit, `design` back; `budgets` states uncertainty after the GUM, of what was measured and of a
predicted lift force; `next_tests` plans what to measure next, and `resolution` says what a list of conditions can tell
at all.
"""

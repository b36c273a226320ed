"""Trial tables and friction laws -> fitted parameters with honest uncertainty, a verdict, lift forces, the next tests.

The fit: `problem` is the least-squares problem and solves thousands of those at once, `fit` makes it of a trial table
and searches from a few good starts; `statistics` knows scatter, covariance, identifiability and criteria,
`scatter` is the one model of scatter, whose variances `reml` estimates, `result` is what a fit hands on, with the words
and rules of the verdict, and `assembled` from what was found. `intervals` follows profiles of parameters and lift
forces. `store` writes, loads and verifies fits.
Its quality: `compare` ranks laws by their fits to condition means (`standing`) and chooses one, `diagnose` says why a
rope does not obey the capstan equation. Its use: `predict` gives the lift force of a wheel, and laws for lmfit, `design`
the wheel for a lift force; `budgets` states uncertainty after the GUM, of measured and of predicted forces; `next_tests`
plans the next measurements with the search of `exchange`, and `resolution` says what a list of conditions can determine.
"""

"""Trial tables and friction laws -> fitted parameters with honest uncertainty, a verdict, and lift forces.

`table` reads trials; `problem` makes them a least-squares problem, `levenberg` solves thousands of those at once, and
`fit` searches with it; `statistics` knows scatter, covariance, identifiability and criteria, and `assemble` makes a
`result` of what was found. `verdict` holds the words and rules of judgement. `standing` and `compare` weigh laws against
each other, `choice` picks one, `predict` carries it to a wheel, `diagnose` says why a rope does not obey the capstan
equation. `profile` and `bootstrap` find other intervals; `store` writes, loads and verifies fits; `lmfit_model` hands a
law to lmfit.
"""

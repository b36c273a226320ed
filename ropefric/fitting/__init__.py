"""Trial tables and friction laws -> fitted parameters with honest uncertainty, a verdict, lift forces, the next tests.

The fit: `problem` makes a trial table a least-squares problem, `levenberg` solves thousands of those at once, `fit`
searches with it from where `start` says; `statistics` knows scatter, covariance, identifiability and criteria,
`assemble` makes a `result` of what was found. `intervals` finds other intervals, by profile or bootstrap. `store`
writes, loads and verifies fits; `lmfit_model` hands a law to lmfit.
What it is worth: `verdict` holds the words and rules, `compare` weighs laws against each other, `choice` picks one,
`diagnose` says why a rope does not obey the capstan equation.
What it is for: `predict` carries it to a wheel and `design` back; `lift_budget` and `measured_budget` state uncertainty
after the GUM; `next_tests` and `plan_search` plan what to measure next.
"""

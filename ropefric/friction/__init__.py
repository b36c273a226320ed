"""Friction laws of a rope on a wheel and the integral of μ over the wrap.

In: conditions (R_w, R_r, φ, F_B) and parameters. Out: ln F_A, its slopes, and where there is no answer.

`condition`: pulls, and which of them are one condition.
`law`: what a law declares, its calculation by hand, and a rope that runs.
`laws/`: the laws by family, each with everything the tool says of it.
`integral`: closed forms of ∫μ that keep their digits.
"""

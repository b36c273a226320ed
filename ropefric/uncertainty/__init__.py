"""Uncertainty budgets: one engine for forces, fits and scenes.

In, to `budget`: single quantities, and quantities known together with their covariance, with draws from both. Out: a
measurement equation's budget by the law of propagation of uncertainty (JCGM 100), the check by draws (JCGM 101) and
what would make it smaller.
"""

"""Uncertainty budgets after the GUM (JCGM 100), checked by the propagation of distributions (JCGM 101)."""

"""Rules that set values of a series aside, by name; the first is the default."""

from ropefric.registry import Registry
from ropefric.trials.outliers import chauvenet, grubbs, mad, none, two_sigma
from ropefric.trials.outliers.rule import OutlierRule, max_z

__all__ = ["RULES", "OutlierRule", "max_z"]

RULES: Registry[OutlierRule] = Registry(
    "outlier rule", [two_sigma.RULE, grubbs.RULE, chauvenet.RULE, mad.RULE, none.RULE]
)
"""Every rule: two-sigma, grubbs, chauvenet, mad, none."""

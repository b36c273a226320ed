"""Which law of a comparison is used."""

from dataclasses import dataclass

from ropefric.errors import FitError
from ropefric.fitting.comparison import Comparison, ComparisonEntry
from ropefric.fitting.result import FitResult

__all__ = ["Winner", "choose_winner"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Winner:
    """The law that is used.

    Attributes
    ----------
    fit : FitResult
        Its fit.
    entry : ComparisonEntry
        How it stands in the comparison.
    forced : bool
        Whether the user named it.
    doubts : tuple of str
        What is to be known about the choice; empty if nothing.
    """

    fit: FitResult
    entry: ComparisonEntry
    forced: bool
    doubts: tuple[str, ...]


def choose_winner(comparison: Comparison, law: str = "") -> Winner:
    """Return the best law of a comparison whose fit may be used as it stands, or the law that is asked for.

    Parameters
    ----------
    comparison : Comparison
        Laws, best first.
    law : str
        The law to use whatever its place; "" for the best.

    Returns
    -------
    Winner
        Where no law is to be trusted, the best of all, which then says so by its status.

    Raises
    ------
    UnknownNameError
        If the law is not in the comparison.
    FitError
        If the law has no answer on these data.
    """
    if law:
        return _forced(comparison, law)
    fitted = [entry for entry in comparison.ranking if entry.fit is not None]
    good = [entry for entry in fitted if entry.counted and entry.fit is not None and entry.fit.trustworthy]
    chosen = (good or fitted)[0]
    doubts = []
    if good and chosen is not fitted[0]:
        first = fitted[0]
        doubts.append(
            f"{first.law} stands {chosen.aicc - first.aicc:.1f} in AICc before {chosen.law}, but is not to be "
            f"trusted: {first.status}"
        )
    return _winner(chosen, doubts, forced=False)


def _forced(comparison: Comparison, law: str) -> Winner:
    entry = comparison[law]
    if entry.fit is None:
        raise FitError(f"{law} has no answer on these data: {entry.note}", fix="use another law")
    doubts = []
    if not entry.counted:
        doubts.append(f"{law} takes no part in the comparison: {entry.note}")
    elif entry.delta_aicc > 0.0:
        doubts.append(
            f"{law} was asked for; {comparison.best.law} stands {entry.delta_aicc:.1f} in AICc before it"
        )
    return _winner(entry, doubts, forced=True)


def _winner(entry: ComparisonEntry, doubts: list[str], *, forced: bool) -> Winner:
    assert entry.fit is not None  # noqa: S101  (both callers looked)
    return Winner(fit=entry.fit, entry=entry, forced=forced, doubts=tuple(doubts))

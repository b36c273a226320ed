"""How a fit is to be made, checked before it starts."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from numbers import Integral
from typing import Any, Literal

from ropefric.errors import InputError, UnknownNameError
from ropefric.fitting.losses import LOSSES, Loss
from ropefric.friction.law import FrictionLaw
from ropefric.registry import did_you_mean

MOST_STARTS = 10_000
"""Of a search; beyond some hundreds nothing new is found."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitSettings:
    """How a fit is made; the meaning of each is that of `fit_law`."""

    fixed: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]] | None = None
    start: Mapping[str, float] | None = None
    scale_covar: Literal["auto"] | bool = "auto"
    loss: Loss = "linear"
    clustered: bool = True
    n_starts: int = 4
    seed: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as plain data, which `fit_law` takes as keyword arguments again."""
        tree = asdict(self)
        bounds = {name: list(span) for name, span in (self.bounds or {}).items()}
        return tree | {"fixed": dict(self.fixed), "bounds": bounds, "start": dict(self.start or {})}


def check_settings(settings: FitSettings, law: FrictionLaw) -> None:
    """Refuse settings that no fit of this law can follow; return quietly otherwise."""
    for key in ("fixed", "bounds", "start"):
        for name in getattr(settings, key) or {}:
            if name not in law.parameter_names:
                fix = did_you_mean(name, law.parameter_names)
                raise UnknownNameError(f"{law.name} has no parameter {name!r}", key=key, fix=fix)
    for name, (low, high) in (settings.bounds or {}).items():
        if not low < high:
            raise InputError(
                f"the bounds of {name}, {low:g} … {high:g}, leave nothing between them",
                code="RF402",
                key="bounds",
                fix="give (lower, upper), or fix the parameter",
            )
    if settings.loss not in tuple(LOSSES):
        raise UnknownNameError(
            f"unknown loss {settings.loss!r}", key="loss", fix=did_you_mean(str(settings.loss), LOSSES)
        )
    if settings.scale_covar not in ("auto", True, False):
        raise InputError(
            f"{settings.scale_covar!r} is no setting", key="scale_covar", fix="use 'auto', True or False"
        )
    _check_whole("n_starts", settings.n_starts, 1, MOST_STARTS, "a search needs at least one start")
    _check_whole("seed", settings.seed, 0, 2**63, "a seed is a whole number of at least 0")


def _check_whole(key: str, value: Any, least: int, most: int, why: str) -> None:
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
        raise InputError(f"{key} is {value!r:.40}; {why} and at most {most}", key=key)

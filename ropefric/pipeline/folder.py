"""The folder of a campaign's results: what is written there, and what it must never replace."""

import os
from pathlib import Path

from ropefric.errors import DataError
from ropefric.files.folder import OutputFolder
from ropefric.files.toml import read_toml
from ropefric.trials.campaign_model import Campaign

_EXTRACTED = (
    *("trials.csv", "conditions.csv", "problems.csv"),
    *("figures/Rw*deg_F*.png", "figures/Rw*deg_F*.csv"),
)
_FIGURES = (
    *("overview", "mu_facets", "capstan", "fit_over_", "residuals", "ladder"),
    *("tornado", "design_chart", "budget_"),
)
_ANSWERED = (
    *("comparison.csv", "prediction.json", "uncertainty.json", "next_tests.csv", "manifest.json"),
    *("report.html", "summary.txt"),
    *(f"figures/{stem}*.csv" for stem in _FIGURES),
)


def campaign_folder(
    campaign: Campaign,
    folder: str | os.PathLike[str],
    *,
    answers: bool = True,
    force: bool = False,
) -> OutputFolder:
    """Return the folder of a campaign's results, as a context that keeps it from other runs; see `OutputFolder`."""
    from ropefric.friction.laws import ALL_LAWS  # noqa: PLC0415  (an extraction needs none)

    names = (*_ANSWERED, *(f"fits/{law}.json" for law in ALL_LAWS)) if answers else ()
    return OutputFolder(
        folder,
        family="campaign",
        names=(*_EXTRACTED, *names),
        inputs=(
            campaign.path,
            *_trial_list(campaign),
            *dict.fromkeys(trial.path for trial in campaign.trials),
        ),
        basis="trials.csv",
        force=force,
    )


def _trial_list(campaign: Campaign) -> tuple[Path, ...]:
    try:
        name = read_toml(campaign.path).data.get("trials")
    except DataError:  # its file is gone since it was loaded
        return ()
    return (campaign.path.parent / name,) if isinstance(name, str) else ()

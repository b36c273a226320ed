"""What the functions on campaigns take: a campaign, or the path of its file."""

import os

from ropefric.trials.campaign import load_campaign
from ropefric.trials.campaign_model import Campaign

__all__ = ["PathLike", "as_campaign", "load_campaign"]

PathLike = str | os.PathLike[str]
"""A file or folder."""


def as_campaign(campaign: Campaign | PathLike) -> Campaign:
    """Return a campaign, loaded where its file is given."""
    return campaign if isinstance(campaign, Campaign) else load_campaign(campaign)

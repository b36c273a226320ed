"""Which of the two kinds of TOML files a tree is: a campaign of measured trials, or a scene to solve."""

from collections.abc import Mapping
from typing import Any

# None of these is a key of any scene.
_OF_CAMPAIGNS = ("trials", "wheels", "cells", "protocol", "rejection", "import")


def is_scene(data: Mapping[str, Any]) -> bool:
    """Return whether a TOML tree says of which system it is, as every scene does and no campaign."""
    return "system" in data


def is_campaign(data: Mapping[str, Any]) -> bool:
    """Return whether a TOML tree has what only campaigns have, and names no system."""
    schema = str(data.get("schema", ""))
    named = schema.startswith("ropefric.campaign") or any(key in data for key in _OF_CAMPAIGNS)
    return named and not is_scene(data)

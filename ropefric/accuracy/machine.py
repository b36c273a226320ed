"""The machine a time was taken on: a time without it says nothing."""

import os
import platform
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

_CPUINFO = Path("/proc/cpuinfo")


@dataclass(frozen=True, slots=True, kw_only=True)
class Machine:
    """What ran."""

    cpu: str
    cores: int
    system: str
    python: str
    numpy: str
    scipy: str

    @property
    def line(self) -> str:
        """Return all of it in a line."""
        cores = "1 core" if self.cores == 1 else f"{self.cores} cores"
        made = f"Python {self.python}, numpy {self.numpy}, scipy {self.scipy}"
        return f"{self.cpu}, {cores}, {self.system}; {made}"

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)


def this_machine() -> Machine:
    """Return the machine this runs on."""
    return Machine(
        cpu=_cpu_model(),
        cores=os.cpu_count() or 1,
        system=f"{platform.system()} {platform.machine()}",
        python=platform.python_version(),
        numpy=version("numpy"),
        scipy=version("scipy"),
    )


def _cpu_model() -> str:
    """Return the model where the system tells it in a file, and the platform's word for it otherwise."""
    try:
        lines = _CPUINFO.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return (models[0] if models else "") or platform.processor() or "unknown processor"

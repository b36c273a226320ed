"""A good campaign to spoil."""

import re
from pathlib import Path

import pytest

from ropefric.errors import RopefricError
from ropefric.trials.campaign import check_campaign, load_campaign

GOOD = Path(__file__).parent / "good"


class Bench:
    """A campaign in a folder, whose texts can be changed by replacing parts."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = folder / "campaign.toml"
        self.table = folder / "trials.csv"
        (folder / "recordings").mkdir()
        for name in "abc":
            self.record(f"{name}.csv")
        self.write((GOOD / "campaign.toml").read_bytes(), (GOOD / "trials.csv").read_bytes())

    def record(self, name):
        path = self.folder / "recordings" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("time_s,counts\n", encoding="utf-8")

    def write(self, toml=None, trials=None):
        for path, text in ((self.path, toml), (self.table, trials)):
            if text is not None:
                path.write_bytes(text if isinstance(text, bytes) else text.encode())

    def spoil(self, old, new, *, pattern=False):
        text = self.path.read_text(encoding="utf-8")
        changed = re.sub(old, new, text, flags=re.MULTILINE) if pattern else text.replace(old, new)
        assert changed != text, f"{old!r} is not in the campaign file"
        self.write(toml=changed)

    def spoil_table(self, old, new):
        text = self.table.read_text(encoding="utf-8")
        assert old in text
        self.write(trials=text.replace(old, new))

    def problems(self):
        """Problems with paths cut to the file's name; asserts that load and check tell the same story."""
        found = check_campaign(self.path)
        errors = tuple(problem for problem in found if problem.severity == "error")
        if errors:
            with pytest.raises(RopefricError) as caught:
                load_campaign(self.path)
            assert caught.value.problems == errors
        else:
            assert load_campaign(self.path).warnings == found
        return found

    def errors(self):
        return [problem for problem in self.problems() if problem.severity == "error"]

    def only(self):
        errors = self.errors()
        assert len(errors) == 1, "\n".join(map(str, errors))
        return errors[0]

    def warnings(self):
        return [problem for problem in self.problems() if problem.severity == "warning"]


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)

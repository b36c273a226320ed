"""docs/python.md: its code runs from top to bottom, its names are the interface's, and what it prints is printed."""

import re
from pathlib import Path

import ropefric as rf

PAGE = (Path(__file__).parents[1] / "docs" / "python.md").read_text(encoding="utf-8")


def test_the_code_runs_and_prints_what_stands_there(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code = "\n".join(re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL))
    exec(compile(code, "docs/python.md", "exec"), {})  # noqa: S102  (our own page)
    assert (tmp_path / "fit.png").stat().st_size > 1000
    shown = re.search(r"```text\n(.*?)```", PAGE, re.DOTALL)[1]
    assert shown in capsys.readouterr().out


def test_every_public_name_is_on_the_page():
    assert set(rf.__all__) - {"__version__"} == set(re.findall(r"\brf\.(\w+)", PAGE)) & set(rf.__all__)
    assert set(re.findall(r"\brf\.(\w+)", PAGE)) <= set(rf.__all__)

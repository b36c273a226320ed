"""What README and docs print, written anew: the measured blocks where their markers are, and the sessions.

`python tests/regenerate_readme.py [BLOCK …]` measures the blocks, `python tests/regenerate_readme.py sessions [PAGE …]`
runs the sessions, of all pages or of those named. The sentences of the blocks speak of errors and counted work, which
are the same everywhere; times are in the pictures only, and the machine they were taken on is named beside them.
"""

import contextlib
import importlib.util
import math
import re
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import ModuleType

from ropefric.accuracy.measure import error_table, measure_studies, this_machine
from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.studies.picks import PICKERS
from ropefric.accuracy.studies.press_transient import rk4_limit_s, start_up
from ropefric.accuracy.studies.scenes import PROBLEMS, planned
from ropefric.plotting.style import house_style
from ropefric.plotting.work_precision import draw_work_precision

__all__ = ["MACHINE_LINE", "PICTURES", "cost_block", "hard_cases", "with_blocks", "write_pictures"]

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "data" / "pictures"
PICTURES = {
    "integral": "many",
    "interval": "",
    "press-transient": "stiff",
    "blade-modes": "blade",
    "scenes": "",
}
"""The case of each study that is shown; all of it where none is named."""
MACHINE_LINE = "Times in the pictures: "
_DPI = 80
_PERCENT = "\N{NO-BREAK SPACE}%"
# Below this an error is rounding, which every processor and every version of SciPy does in its own way.
_FLOOR = 1e-13


def enough(study, accuracy, case="", *, method=""):
    """Return the setting of the least work with an error of at most `accuracy`, the same on every machine."""
    good = [row for row in error_table(study, case, method=method) if row.error <= accuracy]
    return min(good, key=lambda row: (row.evaluations, row.error))


def cost_block(machine: str) -> str:
    """Return pictures with a sentence each, every number from the errors and the work of the studies."""
    parts = []
    for study, sentence in _SENTENCES.items():
        text = sentence()
        parts.append(f"![{STUDIES[study].title}](../data/pictures/cost-{study}.png)\n\n{text}\n")
    return "\n".join([*parts, f"{MACHINE_LINE}{machine}.\n"])


def _integral() -> str:
    segments, points = (
        enough("integral", 1e-6, method=name).setting for name in ("segment sum", "gauss-legendre")
    )
    cases = STUDIES["integral"].cases
    errors = [error_table("integral", case.name, method="closed form")[0].error for case in cases]
    from_zero = error_table("integral", "from-zero", method="segment sum")[-1]
    return (
        f"**Lift force.** For a relative error of 1e-6 the segment sum of the paper needs {segments}, "
        f"Gauss-Legendre {points}. The closed form needs none; its error is below {_below(max(errors))} in all "
        f"{len(cases)} cases. If the rope starts without tension and μ is infinite, {from_zero.setting} still have an "
        f"error of {100 * from_zero.error:.1g} %. The plan of a hoist always uses the closed form."
    )


def _press() -> str:
    limit_ms = 1e3 * rk4_limit_s(start_up("stiff").eigenvalues)
    steps = [enough("press-transient", accuracy, "stiff", method="rk4") for accuracy in (1e-2, 1e-5)]
    (exact,) = error_table("press-transient", "stiff", method="exact")
    assert steps[0] == steps[1], "stability and accuracy need different steps"
    return (
        f"**Start-up of a press.** On a stiff belt Runge-Kutta is unstable with steps above {limit_ms:.2g} ms. With "
        f"{steps[0].setting.removeprefix('step ')} its error is below {_below(steps[0].error)}, even if a larger error "
        f"would do. The matrix exponential allows any step; its error is below {_below(exact.error)}."
    )


def _blade() -> str:
    (string,) = error_table("blade-modes", "blade", method="string")
    one, thin = (enough("blade-modes", 1e-6, "blade", method=f"Galerkin, {name}").setting
                 for name in ("one element", "thin end elements"))  # fmt: skip
    return (
        f"**Blade.** The string has an error of {100 * string.error:.2g} %. A beam with a relative error of 1e-6 needs "
        f"{one} in one element, or {thin} with thin elements at the ends for the boundary layers."
    )


def _interval() -> str:
    (covariance,), (profile,), draws = (
        error_table("interval", "curved", method=name) for name in ("covariance", "profile", "monte carlo")
    )
    n = draws[-1].setting.removeprefix("n = ")
    return (
        "**Intervals.** Of a linear law the covariance is exact. On the law of a thick rope, with a scatter of 40 % a "
        f"pull, its interval is {100 * covariance.error:.0f} % off, and so is that of {n} draws. "
        f"The profile of the likelihood takes more time and has an error below {_below(profile.error)}."
    )


def _scenes() -> str:
    words = []
    for wanted in (0.1, 1e-3):
        plan, _ = planned("saw", wanted)
        rows = error_table("scenes", "saw", method="plan and solve")
        (row,) = [one for one in rows if one.setting == f"accuracy {wanted:g}"]
        n_all = len(plan.simulated) + len(plan.left_out)
        off = f", with an error of {100 * row.error:.1g} %" if plan.left_out else ""
        effects = f"{len(plan.simulated)} of {n_all} effects{off}"
        words.append(f"For an accuracy of {100 * wanted:g} % the plan simulates {effects}.")
    whole = [name for name in PROBLEMS if not planned(name, 0.1)[0].left_out]
    return (
        f"**Scenes.** These are solved with all effects at any accuracy: {', '.join(whole)}. In a blade the "
        f"stiffness takes most time. {' '.join(words)} Planning adds at most a few hundredths to the time of one "
        "machine, and some milliseconds to a sweep. Machines whose error does not depend on the accuracy wanted "
        "share a panel of times."
    )


_SENTENCES = {
    "integral": _integral, "interval": _interval, "press-transient": _press, "blade-modes": _blade, "scenes": _scenes,
}  # fmt: skip


def _below(error: float) -> str:
    """Return the next power of ten with half a decade to spare: another machine's last bit changes nothing."""
    return _power(10.0 ** math.ceil(math.log10(max(math.sqrt(10.0) * error, _FLOOR)) - 1e-9))


def _power(value: float) -> str:
    return f"1e{round(math.log10(value))}"


def picks_block() -> str:
    """Return what six pickers say of recordings of rigs that none of them was made for."""
    lines = ["| recordings | picker | right | wrong | missed | doubtful | made up | error of 95 % below |",
             "|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for case in STUDIES["picks"].cases:
        for method, setting, _, quick in PICKERS:
            if not quick:
                continue
            rows = error_table("picks", case.name, method=method)
            (row,) = [one for one in rows if one.setting == setting]
            shares = [
                _percent(row.shares[name]) for name in ("right", "wrong", "missed", "doubtful", "false")
            ]
            lines.append(f"| {case.name} | {row.name} | {' | '.join(shares)} | {100 * row.error:.2g} % |")
    return "\n".join([*lines, ""])


def _percent(share: float) -> str:
    return f"{100 * share:.0f}{_PERCENT}" if math.isfinite(share) else "–"


def _script(name: str, *parts: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT.joinpath("tests", *parts))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # its dataclasses look there
    spec.loader.exec_module(module)
    return module


def hard_cases() -> ModuleType:
    """Return the script that makes the table of hard cases: its function `table` returns the block."""
    return _script("hard_cases_table", "hard", "table.py")


def small_campaigns() -> ModuleType:
    """Return the study of intervals and verdicts, which makes its two tables."""
    return _script("small_campaigns", "accuracy", "small_campaigns.py")


def peers() -> ModuleType:
    """Return the script that times ropefric beside what its users would write instead."""
    sys.path.append(str(ROOT / "tests" / "benchmarks"))
    return _script("peers", "benchmarks", "peers.py")


def with_blocks(text: str, blocks: dict[str, str]) -> str:
    """Return a text with these blocks between their markers; one without its marker is not put in."""
    for name, block in blocks.items():
        pattern = re.compile(rf"(<!-- {re.escape(name)} -->\n).*?(<!-- end -->)", re.DOTALL)
        text = pattern.sub(lambda found, block=block: f"{found[1]}{block}{found[2]}", text)
    return text


def write_pictures(
    folder: Path, pictures: Mapping[str, str] = PICTURES, *, quick: bool = False
) -> tuple[Path, ...]:
    """Measure the shown case of each study and draw it, small; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, case in pictures.items():
        study = replace(STUDIES[name], cases=(STUDIES[name].case(case),)) if case else STUDIES[name]
        (result,) = measure_studies([study], quick=quick)
        drawn = draw_work_precision(result)
        paths.append(folder / f"cost-{name}.png")
        with house_style():
            drawn.figure.savefig(paths[-1], dpi=_DPI, metadata={"Software": None})
    return tuple(paths)


def write_sessions(names: list[str]) -> list[str]:
    """Run the sessions of the pages whose names end like one of these, of all without; return the pages that changed."""
    sessions = _script("doc_sessions", "docs", "sessions.py")
    changed = []
    for page in sessions.PAGES:
        name = page.relative_to(ROOT).as_posix()
        if (names and not name.endswith(tuple(names))) or not sessions.sessions(page):
            continue
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), sessions.quiet_terminal():
            sessions.prepare(Path(folder))
            text = sessions.run_page(page, anew=True)
        if text != page.read_text(encoding="utf-8"):
            page.write_text(text, encoding="utf-8", newline="\n")
            changed.append(name)
    return changed


def write_blocks(only: list[str]) -> list[str]:
    """Measure these blocks, or all, where their markers are in a page, write them there, and return their names."""
    makers: dict[str, Callable[[], str]] = {"cost": lambda: cost_block(this_machine().line),
                                            "hard-cases": lambda: hard_cases().table(),
                                            "peers": lambda: peers().peers_block(this_machine().line),
                                            "picks": picks_block,
                                            "uncertainty": lambda: small_campaigns().uncertainty_block(),
                                            "verdicts": lambda: small_campaigns().verdicts_block()}  # fmt: skip
    written = []
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        text = page.read_text(encoding="utf-8")
        wanted = [
            name for name in only or [*makers][:-1] if f"<!-- {name} -->" in text
        ]  # the last takes half an hour
        if "cost" in wanted:
            write_pictures(FOLDER)
        if "picks" in wanted:
            write_pictures(FOLDER, {"picks": ""})
        if wanted:
            blocks = {name: makers[name]() for name in wanted}
            text = with_blocks(page.read_text(encoding="utf-8"), blocks)  # it may have been edited meanwhile
            page.write_text(text, encoding="utf-8", newline="\n")
            written += wanted
    return written


def main(argv: list[str]) -> None:
    """Write what was asked for, and say what was done."""
    done = write_sessions(argv[1:]) if argv[:1] == ["sessions"] else write_blocks(argv)
    sys.stdout.write(f"written anew: {', '.join(done) or 'nothing'}\n")


if __name__ == "__main__":
    main(sys.argv[1:])

"""The measured blocks of the README: `python tests/regenerate_readme.py` writes them where their markers are.

The sentences speak of errors and counted work, which are the same everywhere; times are in the pictures only, and
the machine they were taken on is named beside them.
"""

import importlib.util
import math
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

from ropefric.accuracy.measure import enough, error_table, measure_studies, this_machine
from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.studies.press_transient import start_up
from ropefric.accuracy.studies.scenes import PROBLEMS, planned
from ropefric.plotting.style import house_style
from ropefric.plotting.work_precision import draw_work_precision
from ropefric.systems.press.transient.integrators import rk4_limit_s

__all__ = ["MACHINE_LINE", "PICTURES", "cost_block", "hard_cases", "with_blocks", "write_pictures"]

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "data" / "pictures"
PICTURES = {
    "integral": "many",
    "press-transient": "stiff",
    "blade-modes": "blade",
    "scenes": "saw",
}
"""The case of each study that is shown."""
MACHINE_LINE = "Times in the pictures: "
_DPI = 80
# Below this an error is rounding, which every processor and every version of SciPy does in its own way.
_FLOOR = 1e-13


def cost_block(machine: str) -> str:
    """Return pictures with a sentence each, every number from the errors and the work of the studies."""
    parts = []
    for study, sentence in _SENTENCES.items():
        text = sentence()
        parts.append(f"![{STUDIES[study].title}](data/pictures/cost-{study}.png)\n\n{text}\n")
    return "\n".join([*parts, f"{MACHINE_LINE}{machine}.\n"])


def _integral() -> str:
    segments, points = (
        enough("integral", 1e-6, method=name).setting for name in ("segment sum", "gauss-legendre")
    )
    cases = STUDIES["integral"].cases
    errors = [error_table("integral", case.name, method="closed form")[0].error for case in cases]
    from_zero = error_table("integral", "from-zero", method="segment sum")[-1]
    return (
        f"**Lift force.** To one part in a million the paper's segment sum takes {segments} and Gauss-Legendre "
        f"{points}, the closed form none, off by less than {_below(max(errors))} in all {len(cases)} cases. "
        f"Where the rope starts without tension and μ is infinite, {from_zero.setting} are still off by "
        f"{100 * from_zero.error:.1g} %. A hoist's plan takes the closed form at every accuracy."
    )


def _press() -> str:
    limit_ms = 1e3 * rk4_limit_s(start_up("stiff").eigenvalues)
    steps = [enough("press-transient", accuracy, "stiff", method="rk4") for accuracy in (1e-2, 1e-5)]
    (exact,) = error_table("press-transient", "stiff", method="exact")
    assert steps[0] == steps[1], "stability and accuracy ask for different steps"
    return (
        f"**Start-up of a press.** On a stiff belt Runge-Kutta is unstable beyond steps of {limit_ms:.2g} ms, and at "
        f"{steps[0].setting.removeprefix('step ')} is accurate to {_below(steps[0].error)} whether that is wanted or "
        f"not; the matrix exponential takes any step and is off by less than {_below(exact.error)}."
    )


def _blade() -> str:
    (string,) = error_table("blade-modes", "blade", method="string")
    one, thin = (
        enough("blade-modes", 1e-6, "blade", method=f"Galerkin, {name}").setting
        for name in ("one element", "thin end elements")
    )
    return (
        f"**Blade.** The string is off by {100 * string.error:.2g} %. A beam to one part in a million takes {one} in "
        f"one element, and {thin} where thin elements at the ends carry their boundary layers."
    )


def _scenes() -> str:
    words = []
    for wanted in (0.1, 1e-3):
        plan, _ = planned("saw", wanted)
        rows = error_table("scenes", "saw", method="plan and solve")
        (row,) = [one for one in rows if one.setting == f"accuracy {wanted:g}"]
        n_all = len(plan.simulated) + len(plan.left_out)
        off = f"is off by {100 * row.error:.1g} %" if plan.left_out else "is where all effects are"
        words.append(
            f"asked for {100 * wanted:g} %, it simulates {len(plan.simulated)} of {n_all} effects and {off}"
        )
    whole = [name for name in PROBLEMS if not planned(name, 0.1)[0].left_out and name != "start-up"]
    return (
        f"**Scenes.** What is quick is solved whole at any accuracy: {', '.join(whole)}. Of a blade only the stiffness "
        f"takes time. Planned and solved, {'; '.join(words)}. No plan takes longer than everything."
    )


_SENTENCES = {"integral": _integral, "press-transient": _press, "blade-modes": _blade, "scenes": _scenes}


def _below(error: float) -> str:
    """Return the next power of ten with half a decade to spare: another machine's last bit changes nothing."""
    return _power(10.0 ** math.ceil(math.log10(max(math.sqrt(10.0) * error, _FLOOR)) - 1e-9))


def _power(value: float) -> str:
    return f"1e{round(math.log10(value))}"


def hard_cases() -> ModuleType:
    """Return the script that makes the table of hard cases: its function `table` returns the block."""
    path = ROOT / "tests" / "hard" / "table.py"
    spec = importlib.util.spec_from_file_location("hard_cases_table", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def with_blocks(text: str, blocks: dict[str, str]) -> str:
    """Return a text with these blocks between their markers; one without its marker is not put in."""
    for name, block in blocks.items():
        pattern = re.compile(rf"(<!-- {re.escape(name)} -->\n).*?(<!-- end -->)", re.DOTALL)
        text = pattern.sub(lambda found, block=block: f"{found[1]}{block}{found[2]}", text)
    return text


def write_pictures(folder: Path, *, quick: bool = False) -> tuple[Path, ...]:
    """Measure the shown case of each study and draw it, small; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, case in PICTURES.items():
        study = replace(STUDIES[name], cases=(STUDIES[name].case(case),))
        (result,) = measure_studies([study], quick=quick)
        drawn = draw_work_precision(result)
        paths.append(folder / f"cost-{name}.png")
        with house_style():
            drawn.figure.savefig(paths[-1], dpi=_DPI, metadata={"Software": None})
    return tuple(paths)


def main() -> None:
    """Write pictures and blocks, and say what was done."""
    readme = ROOT / "README.md"
    text = readme.read_text(encoding="utf-8")
    wanted = [name for name in ("cost", "hard-cases") if f"<!-- {name} -->" in text]
    blocks = {}
    if "cost" in wanted:
        write_pictures(FOLDER)
        blocks["cost"] = cost_block(this_machine().line)
    if "hard-cases" in wanted:
        blocks["hard-cases"] = hard_cases().table()
    readme.write_text(with_blocks(text, blocks), encoding="utf-8", newline="\n")
    sys.stdout.write(f"written to {readme.name}: {', '.join(wanted) or 'nothing, there are no markers'}\n")


if __name__ == "__main__":
    main()

"""The commands at both ends: a plugin tried before it is used, a fit handed on to a simulator."""

from dataclasses import asdict
from pathlib import Path

import typer

from ropefric.cli import on_first_use, options
from ropefric.cli.commands.wheels import read_levels
from ropefric.cli.options import Answer, command, exit_code_of
from ropefric.cli.output import Output
from ropefric.files.write import refuse_input, refuse_special, write_files

with on_first_use():
    from ropefric import contracts
    from ropefric.fitting import export as exporting
    from ropefric.report import section
    from ropefric.scenes import sweep_table

_RECORDINGS = typer.Option(
    None,
    "--file",
    metavar="FILE",
    help="A recording its reader, or a scene its machine, is tried on; repeatable.",
)
_TABLE = typer.Option(None, "--out", "-o", metavar="TABLE.csv", help="Write the table there.")


@command("ropefric check-plugin my_law.py", order=200)
def check_plugin(
    out: Output,
    plugin_file: str = typer.Argument(
        metavar="PLUGIN.py", help="The plugin: a Python file, or an installed one's name."
    ),
    *,
    files: list[Path] | None = _RECORDINGS,
) -> Answer:
    """Try a plugin: whether its laws, readers, rules, protocols and machines keep the promises that ours keep.

    Exits with 4 when one is broken. A reader is tried on garbage alone, and a machine not at all, until --file names a
    recording or a scene.
    """
    plugin, findings = contracts.check_plugin(plugin_file, tuple(files or ()))
    slots = {said.partition(" ")[0] for said in plugin.declares} & contracts.FILE_CHECKS.keys()
    if slots and not files:
        out.note(
            f"{plugin.source}: give --file, a recording or a scene of its own, to see {', '.join(sorted(slots))} at work"
        )
    broken = [one for one in findings if one.broken]
    rows = [(one.member, "BROKEN" if one.broken else "kept", one.promise) for one in findings]
    table = section.Section(
        title=f"{plugin.source}: {len(findings) - len(broken)} of {len(findings)} promises are kept",
        headings=("declares", "", "promise"), rows=rows, left=3,
    )  # fmt: skip
    lines = tuple(f"{one.member}: {one.broken}" for one in broken)
    shown = [table, *([section.Section(title="What is broken", lines=lines)] if lines else [])]
    data = {"plugin": plugin.to_dict(), "ok": not broken, "promises": [asdict(one) for one in findings]}
    return Answer(data, shown, exit_code_of(not broken))


@command('ropefric export fits/prth-coupled.json --wrap "90 deg .. 1080 deg" --out mu.csv', order=155)
def export(
    out: Output,
    fit_file: Path = typer.Argument(metavar="FIT.json", help="A stored fit."),
    *,
    wrap: str = typer.Option("", metavar="ANGLES", help='φ, a list, or a range: "90 deg .. 1080 deg".'),
    end_tension: str = typer.Option("", metavar="FORCES", help='F_B: "20 N, 80 N".'),
    wheel_radius: str = typer.Option("", metavar="LENGTHS", help='R_w: "20 mm .. 60 mm".'),
    levels: int = typer.Option(12, min=2, help="Settings a range is divided into."),
    rope_diameter: float | None = options.ROPE_DIAMETER,
    file: Path | None = _TABLE,
    force: options.Force = False,
) -> Answer:
    """Hand a fit on to a simulator: a table μ(φ, F_B, R_w), and the constant that stands for it best over that range.

    Of settings that are not given the table covers what was tested. The constant is the one whose largest relative
    error of the lift force over the table is smallest; that error is said. Exits with 4 when the law is not supported by
    its fit.
    """
    if file is not None:  # before the work
        refuse_special(file)
        refuse_input(file, fit_file)
    stored = options.read_fit(fit_file, out)
    asked = {
        "wrap_angle_rad": (wrap, "rad", "--wrap"),
        "end_tension_N": (end_tension, "N", "--end-tension"),
        "wheel_radius_m": (wheel_radius, "m", "--wheel-radius"),
    }
    given = {name: read_levels(*words, levels) for name, words in asked.items() if words[0]}
    rope_m = options.rope_radius(stored, rope_diameter)
    found = exporting.friction_table(stored, rope_radius_m=rope_m, **given)
    columns = {name: getattr(found, name) for name in found._framed}  # noqa: SLF001  (what its frame holds)
    names = ("law", "constant_mu", "constant_error")
    data = {name: getattr(found, name) for name in names} | {
        "rows": found.mu_average.size,
        "extrapolated": int(found.extrapolated.sum()),
        "unanswered": int((found.mu_average != found.mu_average).sum()),
        "files": [],
    }
    if file is not None:
        text = sweep_table.columns_text(columns)
        data["files"] = [
            str(path) for path in write_files(file.parent, {file.name: text.encode()}, overwrite=force)
        ]
        out.note(f"wrote {file}")
    percent = f"{100 * found.constant_error:.3g} %"
    lines = (
        f"{found.mu_average.size} points of law {found.law}, {data['extrapolated']} outside what was tested",
        f"the constant μ = {found.constant_mu:.4g} is off by {percent} of the lift force at most",
    )
    return Answer(
        data, [section.Section(title="A law for a simulator", lines=lines)], exit_code_of(stored.verdict)
    )

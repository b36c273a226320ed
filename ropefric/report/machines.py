"""What a machine has to show beside its few main numbers: a press its rollers and spans, a saw its two sides."""

import math
from collections.abc import Mapping
from typing import Any

from ropefric.report.section import Section, Table

_CHANGE_WORDS = {
    "preload": ("if the preload of all tensioners falls to", "the preload of all tensioners rises to"),
    "speed": ("if the belts run as fast as", "the belts run no faster than"),
    "load": ("if all loads grow by the factor", "all loads fall to what they are times"),
    "friction": ("if the coefficient falls to", "the coefficient rises to"),
}
# A roller without torque uses no friction; what is left of it is rounding.
_ROUNDING = 1e-12
_NOTHING_HOLDS = {
    "preload": "no preload of all tensioners holds",
    "speed": "no slower run of the belts holds",
    "load": "no smaller loads hold",
    "friction": "no coefficient holds",
}


def machine_sections(tree: Mapping[str, Any]) -> list[Section]:
    """Return the tables of a press or a saw from `Solution.to_dict()`; none for a hoist."""
    if "slip" in tree and "tension_N" in tree:
        return _press(tree)
    if "tight" in tree and "slack" in tree:
        return _saw(tree)
    return []


def _number(value: float | None, form: str = ".4g") -> str:
    if value is None or not math.isfinite(value):
        return "–"
    return format(0.0 if abs(value) < _ROUNDING else value, form)


def _press(tree: Mapping[str, Any]) -> list[Section]:
    uncertain = any("utilisation_std" in one for one in tree["slip"].values())
    rows = []
    for name, one in tree["slip"].items():
        cells = [name, _number(one["utilisation"])]
        if uncertain:
            cells.append(_number(one.get("utilisation_std"), ".2g"))
        cells += [_number(one[key]) for key in ("log", "mu_required", "as_printed", "as_plotted")]
        rows.append(tuple(cells))
    headings = ["roller", "utilisation", *(["± std"] if uncertain else []), "log", "mu required"]
    slip = Table(headings=(*headings, "as printed", "as plotted"), rows=tuple(rows))
    spans = Table(
        headings=("span", "T at rest [N]", "T' at speed [N]"),
        rows=tuple(
            (name, _number(tension, ".1f"), _number(tree["effective_tension_N"][name], ".1f"))
            for name, tension in tree["tension_N"].items()
        ),
    )
    return [
        Section(title="Tensions", table=spans, notes=tuple(tree["undetermined"])),
        Section(title="Slip", lines=_slip_lines(tree), table=slip),
        *_start_up(tree),
    ]


def _slip_lines(tree: Mapping[str, Any]) -> tuple[str, ...]:
    lines = []
    if tree["slips"]:
        slipping = ", ".join(f"{name} ({_beyond(tree['slip'][name])})" for name in tree["slips"])
        lines.append(f"rollers that slip already: {slipping}; their belts cannot be pulled like this")
    elif tree["first_to_slip"] is None:
        lines.append("no roller carries a torque")
    else:
        lines.append(f"no roller slips; nearest to it is roller {tree['first_to_slip']}")
    for change, words in _CHANGE_WORDS.items():
        one = tree["critical"][change]
        slips, unit = (
            one["state"] == "slips",
            "" if one["unit"].startswith(("factor", "-")) else f" {one['unit']}",
        )
        if slips and not one["value"]:
            lines.append(f"{_NOTHING_HOLDS[change]} {'it' if len(tree['slips']) == 1 else 'them all'}")
        elif slips:
            last = (
                "it stops" if len(tree["slips"]) == 1 else f"the last of them, roller {one['roller']}, stops"
            )
            lines.append(f"{last} where {words[1]} {one['value']:.4g}{unit}")
        elif one["roller"] is not None:
            lines.append(f"{words[0]} {one['value']:.4g}{unit}, roller {one['roller']} slips first")
    return tuple(lines)


def _beyond(slip: Mapping[str, Any]) -> str:
    use = slip["utilisation"]
    return "its belt lifts off" if use is None else f"utilisation {use:.3g}"


def _start_up(tree: Mapping[str, Any]) -> list[Section]:
    if "start_up" not in tree:
        return []
    found = tree["start_up"]
    rows = [
        (
            name,
            _number(found["peak_utilisation"].get(name)),
            _number(found["first_slip_s"].get(name)),
            _number(found["slipping_s"].get(name)),
        )
        for name in tree["slip"]
    ]
    peak = max(found["peak_tension_N"], key=found["peak_tension_N"].__getitem__)
    lowest_N = min(found["lowest_tension_N"].values())
    lines = (
        f"highest tension: {found['peak_tension_N'][peak]:.1f} N in span {peak}; lowest anywhere: {lowest_N:.1f} N",
        f"work of the drives: {found['drive_work_J']:.4g} J, of which slip takes {found['slip_loss_J']:.4g} J",
        f"the energy balance closes to {abs(found['energy_residual']):.1g}",
    )
    headings = ("roller", "peak utilisation", "first slip [s]", "slips for [s]")
    return [Section(title="Start-up", lines=lines, table=Table(headings=headings, rows=tuple(rows)))]


def _saw(tree: Mapping[str, Any]) -> list[Section]:
    sides = [side for side in ("tight", "slack", "rest") if side in tree]
    modes = len(tree["rest"]["frequencies_Hz"])
    rows = [
        (str(mode + 1), *(_number(tree[side]["frequencies_Hz"][mode], ".3f") for side in sides))
        for mode in range(modes)
    ]
    if "torsion_Hz" in tree["rest"]:
        rows += [
            (f"torsion {mode + 1}", *(_number(tree[side]["torsion_Hz"][mode], ".3f") for side in sides))
            for mode in range(modes)
        ]
    lines = [
        f"{side}: F = {tree[side]['tension_N']:.1f} N, c = {tree[side]['wave_speed_m_s']:.2f} m/s, critical speed "
        + (
            "none (constant-force mounting)"
            if tree[side]["critical_speed_m_s"] is None
            else f"{tree[side]['critical_speed_m_s']:.2f} m/s"
        )
        for side in sides
    ]
    if "speed_m_s" in tree:
        lines.insert(0, f"blade speed {tree['speed_m_s']:.3f} m/s")
    if "wheel" in tree:
        lines.append(f"driving wheel: {100 * tree['wheel']['utilisation']:.3g} % of its grip is used")
    frequencies = Table(headings=("mode", *(f"{side} [Hz]" for side in sides)), rows=tuple(rows))
    return [
        Section(title="Natural frequencies", lines=tuple(lines), table=frequencies),
        *_resonance(tree),
        *_comparison(tree),
    ]


def _resonance(tree: Mapping[str, Any]) -> list[Section]:
    if "resonance" not in tree:
        return []
    rows = tuple(
        (
            one["side"],
            str(one["mode"]),
            f"{one['harmonic']} × {one['excitation']}",
            _number(one["mode_Hz"], ".2f"),
            _number(one["excitation_Hz"], ".2f"),
            f"{100 * one['margin']:+.1f} %",
        )
        for one in tree["resonance"]["nearest"]
    )
    crossings = tuple(
        f"{one['side']} mode {one['mode']} meets {one['harmonic']} × {one['excitation']} at "
        f"{one['speed_m_s']:.2f} m/s, {100 * (one['speed_margin'] or 0.0):+.1f} % off ({one['frequency_Hz']:.2f} Hz)"
        for one in sorted(tree["resonance"]["crossings"], key=lambda one: abs(one["speed_margin"] or 0.0))[:5]
    )
    headings = ("side", "mode", "excitation ", "mode [Hz]", "excitation [Hz]", "margin")
    advice = tree["resonance"]["recommended_preload"]
    lines: tuple[str, ...] = ()
    if advice is not None:
        preload = f"preload {advice['preload_N']:.4g} N: " if "preload_N" in advice else ""
        lines = (preload + advice["advice"],)
    return [
        Section(
            title="What may resonate, the nearest first",
            lines=lines,
            table=Table(headings=headings, rows=rows, left=1),
            notes=crossings,
        )
    ]


def _comparison(tree: Mapping[str, Any]) -> list[Section]:
    if "comparison" not in tree:
        return []
    rows = tuple(
        (
            one["model"],
            one["side"],
            str(one["mode"]),
            _number(one["measured_Hz"], ".2f"),
            _number(one["model_Hz"], ".2f"),
            "–" if one["relative"] is None else f"{100 * one['relative']:+.1f} %",
        )
        for one in tree["comparison"]["deviations"]
    )
    lines = tuple(
        f"{one['side']} mode {one['mode']}: {one['measured_Hz']:g} Hz would need a mounting factor of "
        f"{_number(one['mounting_factor'], '.2f')}. {one['advice']}"
        for one in tree["comparison"]["mounting"]
    )
    headings = ("model", "side", "mode", "measured [Hz]", "model [Hz]", "deviation")
    return [
        Section(title="Against measurement", lines=lines, table=Table(headings=headings, rows=rows, left=2))
    ]

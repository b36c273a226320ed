"""Checks for authors of laws, readers, outlier rules, protocols and machines: the same that the package's own pass.

`check_law` and its like raise `PromiseError` at the first promise that is broken, `check_plugin` tries all that a file
declares. Each promise is the first line of the check that tries it.
"""

import json
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, RopefricError
from ropefric.fitting.fit import guess
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.plugins import Plugin, load_plugin, registry_of, unloaded_after
from ropefric.scenes.explain import explain_solution
from ropefric.scenes.kind import Kind
from ropefric.scenes.scene import load_scene
from ropefric.scenes.solve import solve_scene
from ropefric.scenes.sweep import Axis, sweep_scene
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.protocols import Protocol
from ropefric.traces.readers import READERS, read_recordings
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader
from ropefric.traces.trace import ForceTrace
from ropefric.trials.outliers import OutlierRule

_EFFECTS = {"size", "wrap-dependence", "end-tension", "bending-stiffness", "offset", "groove"}
_QUESTIONS = ("log_lift", "jacobian", "log_lift_gradient_conditions")
_GARBAGE = (b"", bytes(4096), np.random.default_rng(0).bytes(20_000), b"Messung abgebrochen\n" * 50)


class PromiseError(AssertionError):
    """A broken promise of a member."""


class Finding(NamedTuple):
    """One promise of one member: kept where `broken` is empty."""

    member: str
    promise: str
    broken: str = ""


def _must(holds: Any, what: str) -> None:
    if not np.all(holds):
        raise PromiseError(what)


def _close(found: FloatArray, truth: FloatArray, what: str, rtol: float, atol: float) -> None:
    _must(found.shape == truth.shape, f"{what} has the shape {found.shape}, not {truth.shape}")
    off = int(np.argmax(np.abs(found - truth) - atol - rtol * np.abs(truth)))
    same = np.allclose(found, truth, rtol, atol)
    _must(same, f"{what} is {found.flat[off]:.8g}, not {truth.flat[off]:.8g}")


# ---- friction laws ----


def bench() -> Conditions:
    """Return 6 wheels, 6 wraps and 6 loads, as on a bench."""
    wheels_m, loads_N = [0.02, 0.03, 0.04, 0.06, 0.08, 0.12], [2.0, 5.0, 10.0, 20.0, 80.0, 200.0]
    grid = np.meshgrid(wheels_m, 0.0049, np.pi * np.array([0.5, 1, 2, 3, 4, 6]), loads_N)
    return Conditions(**{name: values.ravel() for name, values in zip(SETTINGS, grid, strict=True)})


def typical(law: FrictionLaw) -> FloatArray:
    """Return the typical parameters of a law."""
    return np.array([parameter.start for parameter in law.parameters])


def varied(conditions: Conditions, **changes: Any) -> Conditions:
    """Return conditions with some settings changed."""
    return Conditions(**{name: getattr(conditions, name) for name in SETTINGS} | changes)


def _some_sets(law: FrictionLaw, seed: int, m: int = 6) -> FloatArray:
    """Return m parameter sets near the typical one."""
    return typical(law) * np.random.default_rng(seed).uniform(0.7, 1.0, (m, len(law.parameters)))


def law_is_declared_whole(law: FrictionLaw) -> None:
    """Equation, source and meanings are said; start values lie within the bounds; effects are known ones."""
    _must(law.equation and law.source, "equation or source is empty")
    _must(law.effects <= _EFFECTS, f"unknown effects {law.effects - _EFFECTS}; known: {sorted(_EFFECTS)}")
    right = {"local"} if "end-tension" in law.effects else {"local", "average"}
    _must(law.coefficient in right, f"coefficient is {law.coefficient!r}, none of {sorted(right)}")
    _must(len(set(law.parameter_names)) == len(law.parameters) > 0, "no parameters, or two of one name")
    for one in law.parameters:
        _must(one.lower <= one.start <= one.upper, f"the start of {one.name} is outside its bounds")
        _must(one.meaning and one.unit and one.name.isidentifier(), f"{one.name} lacks meaning or unit")


def law_takes_many_sets(law: FrictionLaw) -> None:
    """Many parameter sets at once give what each gives by itself, and `rise_and_slopes` the rise to the last bit."""
    plan, sets = bench(), _some_sets(law, 1)
    for question in _QUESTIONS:
        ask = getattr(law, question)
        _close(ask(sets, plan), np.stack([ask(theta, plan) for theta in sets]), question, 1e-13, 1e-15)
    same = law.log_lift_and_jacobian(sets, plan)[0] == law.log_lift(sets, plan)
    _must(same, "the rise of `rise` and of `rise_and_slopes` differ")


def law_slopes_are_derivatives(law: FrictionLaw) -> None:
    """The slopes by the parameters, and by wheel radius, wrap and ln F_B, are those of finite differences."""
    plan, p = bench(), len(law.parameters)
    settings = {"wheel_radius_m": plan.wheel_radius_m, "wrap_angle_rad": plan.wrap_angle_rad}
    settings["end_tension_N"] = np.ones(len(plan))  # whose slope is by the logarithm already
    for theta in _some_sets(law, 2, m=3):
        by_log = law.log_lift_gradient_conditions(theta, plan) * np.column_stack([*settings.values()])
        found = (*law.jacobian(theta, plan).T, *by_log.T)
        steps = [3e-4 * (abs(value) or 1e-2) for value in theta] + [1e-3] * 3
        for i, (name, h) in enumerate(zip((*law.parameter_names, *settings), steps, strict=True)):
            two, one, back, far = (
                law.log_lift(theta + k * h * np.eye(p)[i], plan)
                if i < p
                else law.log_lift(theta, varied(plan, **{name: getattr(plan, name) * np.exp(k * h)}))
                for k in (2, 1, -1, -2)
            )
            truth = (8 * (one - back) - (two - far)) / (12 * h)
            _close(found[i], truth, f"the slope by {name}", 1e-7, 1e-8 * max(np.abs(truth).max(), 1e-3))


def law_grows_from_nothing(law: FrictionLaw) -> None:
    """More wrap or end tension lifts more; towards no wrap F_A goes to F_B, but for an offset or a stiff rope."""
    plan, theta = bench(), typical(law)
    base = law.log_lift(theta, plan)
    _must(base >= plan.log_end_tension, "F_A is below F_B")
    for name in ("wrap_angle_rad", "end_tension_N"):
        more = law.log_lift(theta, varied(plan, **{name: 1.1 * getattr(plan, name)}))
        _must(more > base, f"more {name.rpartition('_')[0].replace('_', ' ')} lifts less")
    if not law.effects & {"offset", "bending-stiffness"}:
        rise = law.log_lift(theta, varied(plan, wrap_angle_rad=1e-6)) - plan.log_end_tension
        _must(rise < 0.05, f"a wrap of 1e-6 rad still lifts e^{rise.max():.3g} F_B")


def law_is_finite_or_refuses(law: FrictionLaw) -> None:
    """Anywhere within the bounds and far outside there is a finite number, or a reason why not."""
    low, high = np.maximum(law.lower, -1e3), np.minimum(law.upper, 1e3)
    drawn = np.random.default_rng(6).uniform(low, high, (120, low.size))
    plan, wild = bench().select(np.arange(0, 216, 7)), (np.full(low.size, x) for x in (0.0, 1e308, -1e308))
    for theta, question in product((*drawn, low, high, *wild), _QUESTIONS):
        with suppress(InputError):
            finite = np.isfinite(getattr(law, question)(theta, plan)).all()
            _must(finite and not law.validity(theta, plan), f"{question} answers where validity refuses")


def law_is_found(law: FrictionLaw) -> None:
    """Start values are near the parameters of clean data."""
    plan, fixed = bench(), [parameter.fixed for parameter in law.parameters]
    for theta in np.where(fixed, typical(law), _some_sets(law, 4, m=3)):
        _close(guess(law, plan, law.log_lift(theta, plan)), theta, "the guess", 0.02, 1e-3)


# ---- outlier rules ----


def rule_keeps_what_cannot_be_judged(rule: OutlierRule) -> None:
    """None of fewer than three values, of equal ones, or of too few for it, is rejected; one bool a value comes out."""
    alike = ([value] * n for value, n in ((3.0, 1), (0.1, 7), (0.0, 20), (1e9 + 0.1, 3), (-5e-324, 9)))
    few = ([*range(n - 1), 1e6] for n in range(3, 21) if not rule.can_reject(n))
    for values in ([], [3.0, 9.0], *alike, *few):
        flagged = rule.flag(values)
        _must(flagged.dtype == np.bool_ and flagged.shape == (len(values),), f"the answer is {flagged!r}")
        _must(not flagged.any(), f"{values[:3]}… loses a value")


def rule_knows_no_order_and_no_unit(rule: OutlierRule) -> None:
    """The order, the unit, the sign and a common offset of the values do not matter, and no value is changed."""
    rng = np.random.default_rng(9)
    for n, outlier in product((3, 4, 5, 7, 10, 12, 30), (0.0, 4.0, 20.0)):
        values = rng.integers(-40, 40, n) / 16.0 + np.eye(n)[0] * outlier
        before, flagged, order = values.copy(), rule.flag(values), rng.permutation(n)
        _must(values == before, "the values are changed")
        _must(rule.flag(values[order]) == flagged[order], f"the order of {values} matters")
        for changed in (values * 2.0**-20, values * 2.0**300, -values, values + 2.0**20):
            _must(rule.flag(changed) == flagged, f"unit or offset of {values} matters")


# ---- protocols ----


def _pull(scale: float = 1.0, start_s: float = 0.0) -> ForceTrace:
    time_s, rng = np.arange(6000) / 1000.0, np.random.default_rng(12)
    force_N = np.interp(time_s, [0.5, 2.5, 2.52, 4.5, 4.6], [0.0, 100.0, 80.0, 80.0, 0.0])
    return ForceTrace(time_s=time_s + start_s, force_N=scale * (force_N + rng.normal(0.0, 0.05, 6000)))


def protocol_gives_results(protocol: Protocol) -> None:
    """Of a pull, a flat, a short and a noisy recording it gives one result or more; a force where the status is ok."""
    _must(protocol.description and protocol.measures in {"peak_N", "plateau", "pair"}, "it is not described")
    noise_N, few_N = np.random.default_rng(13).normal(size=500), np.array([0.0, 1.0, 2.0, 0.0])
    for force_N in (_pull().force_N, noise_N, few_N, np.zeros(500)):
        trace = ForceTrace(time_s=np.arange(force_N.size) / 1000.0, force_N=force_N)
        found: Any = protocol.pick(trace, PickSettings())
        right = isinstance(found, tuple) and found and all(isinstance(one, Breakaway) for one in found)
        _must(right, f"{found!r:.60} is not a tuple of Breakaway")
        forces_N = [one.peak_N for one in found if one.status is Status.OK]
        _must(np.isfinite(forces_N), "ok without a force")
    _must(not forces_N, "a flat recording gives a force")


def protocol_knows_no_clock_and_no_unit(protocol: Protocol) -> None:
    """The same pull an hour later gives the same force, and one of twice the force twice as much."""
    pulls = _pull(), _pull(start_s=3600.0), _pull(scale=2.0)
    was, later, double = ([one.peak_N for one in protocol.pick(it, PickSettings())] for it in pulls)
    for now, factor, what in ((later, 1.0, "an hour later is"), (double, 2.0, "doubled is")):
        same = np.allclose(np.multiply(factor, was), now, rtol=1e-9, equal_nan=True)
        _must(same, f"{was} N {what} {now} N")


# ---- readers and machines: with a file of their own ----


def reader_refuses_garbage(reader: Reader) -> None:
    """A file that is no recording is refused with a RopefricError, never read, and never crashes the reader."""
    dotted = all(one.startswith(".") and one == one.lower() for one in reader.suffixes)
    _must(reader.description and dotted, f"there is no description, or one of {reader.suffixes} is no suffix")
    with TemporaryDirectory() as folder:
        path = Path(folder, f"garbage{(*reader.suffixes, '.dat')[0]}")
        for content in _GARBAGE:
            path.write_bytes(content)
            with suppress(RopefricError):
                read_recordings(path, ImportProfile(format=reader.name))
                raise PromiseError(f"a file of {content[:20]!r}… is not refused")


def reader_reads(reader: Reader, path: Path) -> None:
    """A recording of its format becomes traces of finite force over increasing time."""
    profile = ImportProfile(format=reader.name)
    traces = [assemble_trace(raw, profile) for raw in read_recordings(path, profile)]
    _must(traces, "there is no recording in it")
    sound = [np.diff(one.time_s).min() > 0.0 and np.isfinite(one.force_N).all() for one in traces]
    _must(sound, "the time does not increase, or a force is not finite")


def kind_answers(kind: Kind, path: Path) -> None:
    """A scene has an answer of finite numbers that JSON can hold, and a plan that explains it."""
    scene = load_scene(path)
    _must(scene.kind is kind, f"the scene is one of {scene.kind.name}")
    solution = solve_scene(scene)
    found = {one.name: one.value for one in solution.quantities}
    _must(found and all(np.isfinite(value).all() for value in found.values()), f"the answer is {found}")
    json.dumps([solution.to_dict(), explain_solution(solution).to_dict()], allow_nan=False)


def kind_is_swept(kind: Kind, path: Path) -> None:
    """A sweep over each number that can be swept gives what the scene by itself gives there."""
    scene = load_scene(path)
    alone = {one.name: float(one.value[0]) for one in solve_scene(scene).quantities}
    for key, becomes in kind.sweep_fields.items():
        values = getattr(scene.problem, becomes.field, None)
        if values is not None and np.ndim(values) == 1:
            there = np.array([1.0, 1.001]) * float(values[0]) / becomes.factor
            found = sweep_scene(scene, (Axis(key=key, values=there, unit="", factor=1.0),)).columns
            for name in found.keys() & alone.keys():
                same = np.isclose(found[name][0], alone[name], rtol=1e-9, equal_nan=True)
                _must(same, f"over {key}, {name} is {found[name][0]:.8g}, not {alone[name]:.8g}")


Checks = dict[str, tuple[Callable[..., None], ...]]
CHECKS: Checks = {
    "LAW": (law_is_declared_whole, law_takes_many_sets, law_slopes_are_derivatives, law_grows_from_nothing,
            law_is_finite_or_refuses, law_is_found),
    "RULE": (rule_keeps_what_cannot_be_judged, rule_knows_no_order_and_no_unit),
    "PROTOCOL": (protocol_gives_results, protocol_knows_no_clock_and_no_unit),
    "READER": (reader_refuses_garbage,),
}  # fmt: skip
"""The promises of the members of each registry."""

FILE_CHECKS: Checks = {"READER": (reader_reads,), "KIND": (kind_answers, kind_is_swept)}
"""The promises that need a file: a recording for a reader, a scene for a machine."""


def check_law(law: FrictionLaw) -> None:
    """Try a friction law; raise PromiseError where it breaks a promise.

    Parameters
    ----------
    law : FrictionLaw
        The law, as a plugin declares it.

    Raises
    ------
    PromiseError
        Which promise is broken, at the first one.

    Examples
    --------
    >>> from ropefric.friction.laws import LAWS
    >>> check_law(LAWS["constant"])
    """
    _try("LAW", law)


def check_outlier_rule(rule: OutlierRule) -> None:
    """Try an outlier rule; raise PromiseError where it breaks a promise."""
    _try("RULE", rule)


def check_protocol(protocol: Protocol) -> None:
    """Try a way of measuring; raise PromiseError where it breaks a promise."""
    _try("PROTOCOL", protocol)


def check_reader(reader: Reader, *recordings: Path) -> None:
    """Try a reader, on garbage and on recordings of its format; raise PromiseError where it breaks a promise."""
    with unloaded_after():
        if reader.name not in READERS:
            READERS.add(reader)
        _try("READER", reader, *recordings)


def check_scene_kind(kind: Kind, *scenes: Path) -> None:
    """Try a machine on scenes of it; raise PromiseError where it breaks a promise.

    The machine is one that is known: its plugin is loaded, or named in the scenes.
    """
    _try("KIND", kind, *scenes)


def check_plugin(source: str | Path, files: tuple[Path, ...] = ()) -> tuple[Plugin, tuple[Finding, ...]]:
    """Load a plugin and return which promises its members keep; `files` are recordings and scenes of its kind."""
    plugin = load_plugin(source)
    findings: list[Finding] = []
    for said in plugin.declares:
        slot, name = said.split(" ", 1)
        mine = (path for path in files if (path.suffix == ".toml") == (slot == "KIND"))
        for promise, attempt in _attempts(slot, registry_of(slot)[name], *mine):
            broken = ""
            try:
                attempt()
            except Exception as error:  # noqa: BLE001  (whatever a plugin does, it is told)
                broken = str(error) if isinstance(error, PromiseError) else f"{type(error).__name__}: {error}"
            findings.append(Finding(said, promise, broken))
    return plugin, tuple(findings)


def _attempts(slot: str, member: Any, *files: Path) -> Iterator[tuple[str, Callable[[], None]]]:
    """Give the promises of a member, and what tries each."""
    calls = [(check, (member,)) for check in CHECKS.get(slot, ())]
    calls += [(check, (member, path)) for check in FILE_CHECKS.get(slot, ()) for path in files]  # type: ignore[misc]
    for check, given in calls:
        yield (check.__doc__ or "").strip(), np.errstate(all="ignore")(partial(check, *given))


def _try(slot: str, member: Any, *files: Path) -> None:
    for _, attempt in _attempts(slot, member, *files):
        attempt()

"""What the author of a law, reader, outlier rule, protocol or machine runs on it, to see that it keeps what ours keep.

`check_law` and its like raise `PromiseError` at the first promise that is broken, `check_plugin` tries all that a file
declares. Each promise is the first line of the check that tries it.
"""

import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, RopefricError
from ropefric.fitting.fit import fit_law, guess
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.plugins import Plugin, load_plugin, registry_of, unloaded_after
from ropefric.scenes.explain import explain_scene
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
from ropefric.trials.table import TrialTable

_EFFECTS = {"size", "wrap-dependence", "end-tension", "bending-stiffness", "offset", "groove"}
_MEASURES = {"peak_N", "plateau", "pair"}
_NOISE = np.random.default_rng(0).bytes(20_000)
_GARBAGE = (b"", b"\n", bytes(4096), _NOISE, b"Die Messung wurde abgebrochen.\n" * 50)


class PromiseError(AssertionError):
    """What a member does that it must not, or does not that it must."""


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
    off = np.argwhere(np.abs(found - truth) > atol + rtol * np.abs(truth))
    for at in map(tuple, off[:1].tolist()):
        raise PromiseError(f"{what} is {found[at]:.8g} at {at}, not {truth[at]:.8g}")


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
    right = {"local", "average"} if "end-tension" not in law.effects else {"local"}
    _must(law.coefficient in right, f"coefficient is {law.coefficient!r}, none of {sorted(right)}")
    _must(len(set(law.parameter_names)) == len(law.parameters) > 0, "no parameters, or two of one name")
    for one in law.parameters:
        _must(one.lower <= one.start <= one.upper, f"the start of {one.name} is outside its bounds")
        _must(one.meaning and one.unit and one.name.isidentifier(), f"{one.name} lacks meaning or unit")


def law_takes_many_sets(law: FrictionLaw) -> None:
    """Many parameter sets at once give what each gives by itself, and `rise_and_slopes` the rise to the last bit."""
    plan, sets = bench(), _some_sets(law, 1)
    for question in (law.log_lift, law.jacobian, law.log_lift_gradient_conditions):
        one_by_one = np.stack([question(theta, plan) for theta in sets])
        _close(question(sets, plan), one_by_one, question.__name__, 1e-13, 1e-15)
    together = law.log_lift_and_jacobian(sets, plan)[0]
    _must(together == law.log_lift(sets, plan), "the rise of `rise` and of `rise_and_slopes` differ")


def law_slopes_are_derivatives(law: FrictionLaw) -> None:
    """The slopes by the parameters, and by wheel radius, wrap and ln F_B, are those of finite differences."""
    plan, p = bench(), len(law.parameters)
    settings = {"wheel_radius_m": plan.wheel_radius_m, "wrap_angle_rad": plan.wrap_angle_rad}
    settings["end_tension_N"] = np.ones(len(plan))  # whose slope is by the logarithm already

    def lift(theta: FloatArray, i: int, h: float) -> FloatArray:
        if i < p:
            return law.log_lift(theta + h * np.eye(p)[i], plan)
        name = [*settings][i - p]
        return law.log_lift(theta, varied(plan, **{name: getattr(plan, name) * np.exp(h)}))

    for theta in _some_sets(law, 2, m=4):
        by_log = law.log_lift_gradient_conditions(theta, plan) * np.column_stack([*settings.values()])
        found = np.column_stack([law.jacobian(theta, plan), by_log])
        for i, name in enumerate((*law.parameter_names, *settings)):
            h = 3e-4 * (abs(theta[i]) or 1e-2) if i < p else 1e-3
            near, far = (lift(theta, i, k * h) - lift(theta, i, -k * h) for k in (1, 2))
            truth = (8 * near - far) / (12 * h)
            least = 1e-8 * max(float(np.abs(truth).max()), 1e-3)
            _close(found[:, i], truth, f"the slope by {name}", 1e-7, least)


def law_grows_from_nothing(law: FrictionLaw) -> None:
    """More wrap or end tension lifts more; towards no wrap F_A goes to F_B, but for an offset or a stiff rope."""
    plan, theta = bench(), typical(law)
    base = law.log_lift(theta, plan)
    _must(base >= plan.log_end_tension, "F_A is below F_B")
    for name, what in {"wrap_angle_rad": "wrap", "end_tension_N": "end tension"}.items():
        more = law.log_lift(theta, varied(plan, **{name: 1.1 * getattr(plan, name)}))
        _must(more > base, f"more {what} lifts less")
    if not law.effects & {"offset", "bending-stiffness"}:
        short = (varied(plan, wrap_angle_rad=wrap_rad) for wrap_rad in (1e-4, 1e-6))
        little, less = (law.log_lift(theta, at) - at.log_end_tension for at in short)
        holds_not = (less <= little) & (little < 0.2) & (less < 0.05)
        _must(holds_not, f"a wrap of 1e-6 rad still lifts e^{less.max():.3g} F_B")


def law_is_finite_or_refuses(law: FrictionLaw) -> None:
    """Anywhere within the bounds and far outside there is a finite number, or a reason why not."""
    rng, plan = np.random.default_rng(6), bench().select(np.arange(0, 216, 7))
    low, high = np.maximum(law.lower, -1e3), np.minimum(law.upper, 1e3)
    corners = [low, high, 0.0 * low, np.full(low.size, 1e308), np.full(low.size, -1e308)]
    for theta in [*rng.uniform(low, high, (200, len(low))), *corners]:
        answered = not law.validity(theta, plan)
        for question in (law.log_lift, law.jacobian, law.log_lift_gradient_conditions):
            with suppress(InputError):
                finite = np.isfinite(question(theta, plan))
                _must(answered and finite, f"{question.__name__} answers where validity refuses")


def law_is_found_and_stored(law: FrictionLaw) -> None:
    """Start values and a fit find the parameters of clean data, and the fit comes back from its JSON the same."""
    plan, rng = bench(), np.random.default_rng(8)
    fixed = [parameter.fixed for parameter in law.parameters]
    for theta in np.where(fixed, typical(law), _some_sets(law, 4, m=3)):
        truth = law.log_lift(theta, plan)
        _close(guess(law, plan, truth), theta, "the guess", 0.02, 1e-3)
    columns: dict[str, Any] = {name: getattr(plan, name) for name in SETTINGS}
    columns["peak_N"] = np.exp(truth + rng.normal(0.0, 1e-6, truth.size))
    fit = fit_law(TrialTable(trial=tuple(map(str, range(truth.size))), **columns), law)
    off = float(np.abs(law.log_lift(fit.theta, plan) - truth).max())
    _must(off < 1e-4, f"the fit of data without noise is off by {off:.2g}")
    again = FitResult.from_dict(json.loads(json.dumps(fit.to_dict(), allow_nan=False)))
    _must(again.theta == fit.theta, "the stored fit has other parameters")


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
    for n, outlier in ((n, outlier) for n in (3, 4, 5, 7, 10, 12, 30) for outlier in (0.0, 4.0, 20.0)):
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
    _must(protocol.measures in _MEASURES, f"measures is {protocol.measures!r}, none of {sorted(_MEASURES)}")
    _must(protocol.description, "there is no description")
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
    first, later, double = (
        np.array([one.peak_N for one in protocol.pick(one, PickSettings())]) for one in pulls
    )
    for other, factor, what in ((later, 1.0, "an hour later is"), (double, 2.0, "doubled is")):
        same = np.allclose(factor * first, other, rtol=1e-9, equal_nan=True)
        _must(same, f"{first} N {what} {other} N")


# ---- readers and machines: with a file of their own ----


def reader_refuses_garbage(reader: Reader) -> None:
    """What is no recording is refused in ropefric's words, never read and never a crash."""
    _must(reader.description, "there is no description")
    written = all(one.startswith(".") and one == one.lower() for one in reader.suffixes)
    _must(written, f"suffixes {reader.suffixes}")
    with TemporaryDirectory() as folder:
        path = Path(folder, f"garbage{(*reader.suffixes, '.dat')[0]}")
        for content in _GARBAGE:
            path.write_bytes(content)
            with suppress(RopefricError):
                read_recordings(path, ImportProfile(format=reader.name))
                raise PromiseError(f"a file of {content[:20]!r}… is not refused")


def reader_reads(reader: Reader, path: Path) -> None:
    """A recording of its format becomes traces of finite force over increasing time, twice the same."""
    profile = ImportProfile(format=reader.name)
    first, again = (
        [assemble_trace(raw, profile) for raw in read_recordings(path, profile)] for _ in range(2)
    )
    _must(first, "there is no recording in it")
    for one, other in zip(first, again, strict=True):
        _must(np.diff(one.time_s) > 0.0, "the time does not increase")
        _must(np.isfinite(one.force_N), "a force is not finite")
        _must(np.array_equal(one.force_N, other.force_N), "read twice it is not the same")


def kind_is_declared_whole(kind: Kind) -> None:
    """Schema and system belong to it, and its effects have words."""
    _must(kind.system.effects.kind, "the registry of its effects has no kind")
    for effect in kind.system.effects.values():
        told = effect.adds and effect.instead
        _must(told, f"the effect {effect.name} does not say what it adds, or what instead")


def kind_answers(kind: Kind, path: Path) -> None:
    """A scene has an answer of finite numbers that JSON can hold, and a plan that explains it."""
    scene = load_scene(path)
    _must(scene.kind is kind, f"the scene is one of {scene.kind.name}")
    solution = solve_scene(scene)
    found = {one.name: one.value for one in solution.quantities}
    _must(found and all(np.isfinite(value).all() for value in found.values()), f"the answer is {found}")
    json.dumps([solution.to_dict(), explain_scene(scene).to_dict()], allow_nan=False)


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
    "LAW": (
        law_is_declared_whole, law_takes_many_sets, law_slopes_are_derivatives, law_grows_from_nothing,
        law_is_finite_or_refuses, law_is_found_and_stored,
    ),
    "RULE": (rule_keeps_what_cannot_be_judged, rule_knows_no_order_and_no_unit),
    "PROTOCOL": (protocol_gives_results, protocol_knows_no_clock_and_no_unit),
    "READER": (reader_refuses_garbage,),
    "KIND": (kind_is_declared_whole,),
}  # fmt: skip
"""What a member of each registry promises."""

FILE_CHECKS: Checks = {"READER": (reader_reads,), "KIND": (kind_answers, kind_is_swept)}
"""What can only be seen on a file: a recording for a reader, a scene for a machine."""


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
        for check, given in _calls(slot, registry_of(slot)[name], *mine):
            broken = ""
            try:
                with np.errstate(all="ignore"):
                    check(*given)
            except PromiseError as error:
                broken = str(error)
            except Exception as error:  # noqa: BLE001  (whatever a plugin does, it is told)
                broken = f"{type(error).__name__}: {error}"
            findings.append(Finding(said, (check.__doc__ or "").strip(), broken))
    return plugin, tuple(findings)


def _calls(slot: str, member: Any, *files: Path) -> list[tuple[Callable[..., None], tuple[Any, ...]]]:
    """Return what tries a member, and with what."""
    alone = [(check, (member,)) for check in CHECKS.get(slot, ())]
    return [*alone, *((check, (member, path)) for check in FILE_CHECKS.get(slot, ()) for path in files)]


def _try(slot: str, member: Any, *files: Path) -> None:
    for check, given in _calls(slot, member, *files):
        with np.errstate(all="ignore"):
            check(*given)

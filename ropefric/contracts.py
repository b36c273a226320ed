"""What every law, reader, outlier rule, protocol and machine promises, as checks that ours pass, and plugins must.

A check raises `PromiseError` where its member does not keep what the first line of the docstring says.
"""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, RopefricError, UnknownNameError
from ropefric.fitting.fit import fit_law, guess
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.plugins import Plugin, load_plugin, registry_of
from ropefric.scenes.explain import explain_scene
from ropefric.scenes.kind import Kind
from ropefric.scenes.scene import load_scene
from ropefric.scenes.solve import solve_scene
from ropefric.scenes.sweep import Axis, sweep_scene
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.protocols import Protocol
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader
from ropefric.traces.trace import ForceTrace
from ropefric.trials.outliers import OutlierRule
from ropefric.trials.table import TrialTable

_EFFECTS = {"size", "wrap-dependence", "end-tension", "bending-stiffness", "offset", "groove"}
_MEASURES = {"peak_N", "plateau", "pair"}
_GARBAGE = {
    "an empty file": b"",
    "one blank line": b"\n",
    "zeros": bytes(4096),
    "noise": np.random.default_rng(0).bytes(20_000),
    "prose": b"Die Messung wurde abgebrochen.\n" * 50,
}


class PromiseError(AssertionError):
    """What a member does that it must not, or does not that it must."""


class Finding(NamedTuple):
    """One promise of one member: kept where `broken` is empty."""

    member: str
    promise: str
    broken: str = ""


def bench() -> Conditions:
    """Return 6 wheels, 6 wraps and 6 loads, as on a bench."""
    wheels_m, loads_N = [0.02, 0.03, 0.04, 0.06, 0.08, 0.12], [2.0, 5.0, 10.0, 20.0, 80.0, 200.0]
    wheel, wrap, load = np.meshgrid(wheels_m, np.pi * np.array([0.5, 1, 2, 3, 4, 6]), loads_N)
    columns = zip(SETTINGS, (wheel, np.array(0.0049), wrap, load), strict=True)
    return Conditions(**{name: values.ravel() for name, values in columns})


def _must(holds: Any, what: str) -> None:
    if not np.all(holds):
        raise PromiseError(what)


def _close(found: FloatArray, truth: FloatArray, what: str, rtol: float, atol: float) -> None:
    if found.shape != truth.shape:
        raise PromiseError(f"{what} has the shape {found.shape}, not {truth.shape}")
    off = np.abs(found - truth) > atol + rtol * np.abs(truth)
    if off.any():
        at = tuple(int(i) for i in np.argwhere(off)[0])
        raise PromiseError(f"{what} is {found[at]:.8g} at {at}, not {truth[at]:.8g}")


def _refused(ask: Callable[[], object], error: type[RopefricError], what: str) -> None:
    try:
        ask()
    except error:
        return
    raise PromiseError(f"{what} is not refused with {error.__name__}")


# ---- friction laws ----


def typical(law: FrictionLaw) -> FloatArray:
    """Return the typical parameters of a law."""
    return np.array([parameter.start for parameter in law.parameters])


def some_sets(law: FrictionLaw, seed: int, m: int = 6) -> FloatArray:
    """Return m parameter sets near the typical one."""
    return typical(law) * np.random.default_rng(seed).uniform(0.7, 1.0, (m, len(law.parameters)))


def varied(conditions: Conditions, **changes: Any) -> Conditions:
    """Return conditions with some settings changed."""
    return Conditions(**{name: getattr(conditions, name) for name in SETTINGS} | changes)


def derivative(function: Callable[[float], FloatArray], step: float) -> FloatArray:
    """Return the fourth-order central difference at 0."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


def law_is_declared_whole(law: FrictionLaw) -> None:
    """Equation, source and meanings are said; start values lie within the bounds; effects are known ones."""
    _must(law.equation and law.source, "equation or source is empty")
    _must(law.coefficient in {"local", "average"}, f"coefficient is {law.coefficient!r}")
    strange = sorted(law.effects - _EFFECTS)
    _must(not strange, f"unknown effects {', '.join(strange)}; known: {', '.join(sorted(_EFFECTS))}")
    named = len(set(law.parameter_names)) == len(law.parameters) > 0
    _must(named, "parameters are missing, or two have one name")
    for one in law.parameters:
        inside = one.lower <= one.start <= one.upper
        _must(inside, f"the start {one.start:g} of {one.name} is outside its bounds")
        told = one.meaning and one.unit and one.name.isidentifier()
        _must(told, f"{one.name} lacks its meaning, or its unit")
    again = law.theta_from(law.as_mapping(typical(law)))
    _must(again == typical(law), "parameters by name are not the parameters")
    counts = "end-tension" not in law.effects or law.coefficient == "local"
    _must(counts, "a law that counts end tension as wrap has a local coefficient")


def law_takes_many_sets(law: FrictionLaw) -> None:
    """Many parameter sets at once give what each gives by itself."""
    plan, sets = bench(), some_sets(law, 1)
    for question in (law.log_lift, law.jacobian, law.log_lift_gradient_conditions, law.average_mu):
        one_by_one = np.stack([question(theta, plan) for theta in sets])
        _close(question(sets, plan), one_by_one, question.__name__, 1e-13, 1e-15)
    _must(law.log_lift(sets, plan).shape == (6, 216), "log_lift has a wrong shape")
    _must(law.jacobian(sets, plan).shape == (6, 216, len(law.parameters)), "jacobian has a wrong shape")
    _must(law.local_mu(sets, plan.wrap_angle_rad, plan).shape == (6, 216), "local_mu has a wrong shape")
    _must(law.admissible(sets, plan), "ordinary pulls at ordinary parameters are refused")
    _must(law.validity(sets, plan) == (), "an answer is given and refused at once")


def law_lift_and_jacobian_agree(law: FrictionLaw) -> None:
    """To the last bit: `rise_and_slopes` gives the rise of `rise`."""
    plan = bench()
    zero = varied(plan, wrap_angle_rad=np.where(plan.wrap_angle_rad > 10.0, 0.0, plan.wrap_angle_rad))
    sets = some_sets(law, 5)
    for conditions in (plan, zero) if law.admissible(sets, zero).all() else (plan,):
        for theta in (sets, sets[0]):
            log_lift, jacobian = law.log_lift_and_jacobian(theta, conditions)
            _must(np.array_equal(log_lift, law.log_lift(theta, conditions)), "the rise of the two differs")
            _must(np.array_equal(jacobian, law.jacobian(theta, conditions)), "the slopes of the two differ")


def law_jacobian_is_the_derivative(law: FrictionLaw) -> None:
    """The slopes by the parameters are those of finite differences."""
    plan = bench()
    for theta in some_sets(law, 2):
        found = law.jacobian(theta, plan)
        for i, name in enumerate(law.parameter_names):
            unit = np.eye(len(theta))[i]
            step = 3e-4 * (abs(theta[i]) or 1e-2)
            truth = derivative(lambda h, unit=unit, theta=theta: law.log_lift(theta + h * unit, plan), step)  # type: ignore[misc]
            _close(found[:, i], truth, f"the slope by {name}", 1e-7, 1e-8 * np.abs(truth).max())


def law_gradient_by_conditions_is_the_derivative(law: FrictionLaw) -> None:
    """The slopes by wheel radius, wrap and ln F_B are those of finite differences."""
    plan = bench()
    for theta in some_sets(law, 3, m=2):
        found = law.log_lift_gradient_conditions(theta, plan)
        for column, name in enumerate(["wheel_radius_m", "wrap_angle_rad", "end_tension_N"]):
            base = getattr(plan, name)

            def lift(
                h: float, name: str = name, base: FloatArray = base, theta: FloatArray = theta
            ) -> FloatArray:
                return law.log_lift(theta, varied(plan, **{name: base * np.exp(h)}))

            by_log = derivative(lift, 1e-3)
            truth = by_log if name == "end_tension_N" else by_log / base
            least = 1e-8 * max(float(np.abs(truth).max()), 1e-3)
            _close(found[:, column], truth, f"the slope by {name}", 1e-7, least)


def law_grows_with_wrap_and_load(law: FrictionLaw) -> None:
    """More wrap or end tension lifts more, and no rope lifts less than its end tension."""
    plan, theta = bench(), typical(law)
    base = law.log_lift(theta, plan)
    more_wrap = law.log_lift(theta, varied(plan, wrap_angle_rad=plan.wrap_angle_rad * 1.1))
    _must(more_wrap > base, "more wrap lifts less")
    more_load = law.log_lift(theta, varied(plan, end_tension_N=plan.end_tension_N * 1.1))
    _must(more_load > base, "more end tension lifts less")
    _must(base >= plan.log_end_tension, "F_A is below F_B")


def law_needs_wrap_to_hold(law: FrictionLaw) -> None:
    """Towards a wrap of zero F_A goes to F_B; only a law with an offset, or of a rope that stands off, may differ."""
    if law.effects & {"offset", "bending-stiffness"}:
        return
    theta = typical(law)
    short = (varied(bench(), wrap_angle_rad=wrap_rad) for wrap_rad in (1e-4, 1e-6))
    little, less = (law.log_lift(theta, at) - at.log_end_tension for at in short)
    holds_not = (less <= little) & (little < 0.2) & (less < 0.05)
    _must(holds_not, f"a wrap of 1e-6 rad still lifts e^{less.max():.3g} F_B")


def law_local_and_average_belong_together(law: FrictionLaw) -> None:
    """The local coefficient is the slope of ln F along the wrap, and the average one its mean."""
    plan, theta, h = bench(), typical(law), 1e-5
    local = law.local_mu(theta, plan.wrap_angle_rad, varied(plan, wrap_angle_rad=1.0))
    beyond, before = (
        law.log_lift(theta, varied(plan, wrap_angle_rad=(1 + sign * h) * plan.wrap_angle_rad))
        for sign in (1, -1)
    )
    _close(local, (beyond - before) / (2 * h * plan.wrap_angle_rad), "the local coefficient", 1e-7, 1e-8)
    rise = law.log_lift(theta, plan) - plan.log_end_tension
    _close(law.average_mu(theta, plan) * plan.wrap_angle_rad, rise, "the average coefficient", 1e-12, 1e-14)
    _refused(lambda: law.average_mu(theta, varied(plan, wrap_angle_rad=0.0)), InputError, "a wrap of zero")


def law_guess_finds_clean_truth(law: FrictionLaw) -> None:
    """Start values come from the data, lie within the bounds, and find a truth without noise."""
    plan, rng = bench(), np.random.default_rng(4)
    fixed = [parameter.fixed for parameter in law.parameters]
    for theta in np.where(fixed, typical(law), some_sets(law, 4, m=3)):
        found = guess(law, plan, law.log_lift(theta, plan))
        _must((law.lower <= found) & (found <= law.upper), "the guess lies outside the bounds")
        _close(found, theta, "the guess", 0.02, 1e-3)
        noisy = guess(law, plan, law.log_lift(theta, plan) + rng.normal(0, 0.017, len(plan)))
        off = float(np.abs(law.log_lift(noisy, plan) - law.log_lift(theta, plan)).max())
        _must(off < 0.1, f"from data with 1.7 % of noise, the guess is off by e^{off:.3g}")


def law_guess_survives_poor_data(law: FrictionLaw) -> None:
    """One pull, or four alike, of whatever force, give start values within the bounds."""
    for wraps in ([3.0], [3.0] * 4):
        settings = zip(SETTINGS, (0.04, 0.005, wraps, 20.0), strict=True)
        pulls = Conditions(**{name: np.array(value) for name, value in settings})
        for rise in (0.5, 0.0, -0.5, 40.0):
            found = guess(law, pulls, pulls.log_end_tension + rise)
            _must(np.isfinite(found) & (law.lower <= found) & (found <= law.upper), f"the guess is {found}")


def law_refuses_bad_parameters(law: FrictionLaw) -> None:
    """Parameters of the wrong number, not finite, or of unknown names are refused."""
    plan, p = bench(), len(law.parameters)
    _refused(lambda: law.log_lift(np.zeros(p + 1), plan), InputError, "one parameter too many")
    _refused(lambda: law.log_lift(np.full(p, np.nan), plan), InputError, "a parameter that is not finite")
    _refused(lambda: law.log_lift(["a"] * p, plan), InputError, "text for a parameter")
    _refused(lambda: law.theta_from({"no such": 1.0}), UnknownNameError, "an unknown parameter")
    if not all(parameter.fixed for parameter in law.parameters):
        _refused(lambda: law.theta_from({}), InputError, "a missing parameter")


def law_is_finite_or_refuses(law: FrictionLaw) -> None:
    """Anywhere within the bounds and far outside there is a finite number, or a reason why not."""
    rng, plan = np.random.default_rng(6), bench().select(np.arange(0, 216, 7))
    low, high = np.maximum(law.lower, -1e3), np.minimum(law.upper, 1e3)
    inside = [*rng.uniform(low, high, (200, len(low))), law.lower, law.upper]
    wild = [np.full(len(low), value) for value in (0.0, 1e308, -1e308)]
    for theta in (one for one in [*inside, *wild] if np.isfinite(one).all()):
        answered = not law.validity(theta, plan)
        _must(bool(law.admissible(theta, plan)) == answered, "validity and admissible disagree")
        for question in (law.log_lift, law.jacobian, law.log_lift_gradient_conditions):
            try:
                found = question(theta, plan)
            except InputError:
                continue
            _must(answered and np.isfinite(found), f"{question.__name__} answers where validity refuses")


def law_is_fitted_and_stored(law: FrictionLaw) -> None:
    """A fit of it finds the parameters of a clean truth, and comes back from its JSON the same."""
    plan = bench()
    theta = np.where([one.fixed for one in law.parameters], typical(law), some_sets(law, 7, m=1)[0])
    table = TrialTable(
        trial=tuple(f"t{i}" for i in range(len(plan))),
        **{name: getattr(plan, name) for name in SETTINGS},
        peak_N=np.exp(law.log_lift(theta, plan))
        * np.exp(np.random.default_rng(8).normal(0, 1e-6, len(plan))),
    )
    fit = fit_law(table, law)
    off = float(np.abs(law.log_lift(fit.theta, plan) - law.log_lift(theta, plan)).max())
    _must(off < 1e-4, f"the fit of data without noise is off by {off:.2g}")
    again = FitResult.from_dict(json.loads(json.dumps(fit.to_dict(), allow_nan=False)))
    _must(again.theta == fit.theta, "the stored fit has other parameters")


# ---- outlier rules ----


def _series(seed: int) -> Iterator[FloatArray]:
    rng = np.random.default_rng(seed)
    for n in (3, 4, 5, 7, 10, 12, 30):
        for outlier in (0.0, 4.0, 20.0):
            values = rng.integers(-40, 40, n) / 16.0
            values[0] += outlier
            yield values


def rule_keeps_what_cannot_be_judged(rule: OutlierRule) -> None:
    """None of fewer than three values, or of equal ones, is rejected; the answer is one bool a value."""
    for values in ([], [3.0], [3.0, 9.0], [0.1] * 7, [0.0] * 20, [1e9 + 0.1] * 3, [-5e-324] * 9):
        flagged = rule.flag(values)
        right = getattr(flagged, "dtype", None) == np.bool_ and flagged.shape == (len(values),)
        _must(right, f"of {len(values)} values the answer is {flagged!r}")
        _must(not flagged.any(), f"{values[:3]}… loses a value")


def rule_needs_finite_values(rule: OutlierRule) -> None:
    """Values that are missing or not finite are refused."""
    for bad in (np.nan, np.inf, -np.inf, 1e305):
        _refused(lambda bad=bad: rule.flag([1.0, 2.0, bad, 3.0]), InputError, f"the value {bad}")  # type: ignore[misc]


def rule_knows_no_order_and_no_unit(rule: OutlierRule) -> None:
    """The order, the unit, the sign and a common offset of the values do not matter, and no value is changed."""
    for values in _series(9):
        before, flagged = values.copy(), rule.flag(values)
        _must(np.array_equal(values, before), "the values are changed")
        order = np.random.default_rng(10).permutation(values.size)
        _must(np.array_equal(rule.flag(values[order]), flagged[order]), f"the order of {values} matters")
        for changed in (values * 2.0**-20, values * 2.0**300, -values, values + 2.0**20):
            _must(np.array_equal(rule.flag(changed), flagged), f"unit or offset of {values} matters")


def rule_says_when_it_can_reject(rule: OutlierRule) -> None:
    """Where `can_reject(n)` is False nothing is rejected; `good_lost` is what simulated good series lose."""
    rng = np.random.default_rng(11)
    for n in (3, 4, 5, 6, 10, 20):
        lost = [int(rule.flag(series).sum()) for series in rng.normal(size=(400, n))]
        if not rule.can_reject(n):
            none = not rule.flag([*range(n - 1), 1e6]).any() and not any(lost)
            _must(none, f"n = {n}: a value is rejected")
        stated, spread = rule.good_lost(n), max(float(np.std(lost)), 0.02) / 20.0
        if np.isfinite(stated):
            near = abs(np.mean(lost) - stated) < 5.0 * spread
            _must(near, f"n = {n}: {np.mean(lost):.3g} lost, {stated:.3g} stated")


# ---- protocols ----


def _ramp(scale: float = 1.0, start_s: float = 0.0) -> ForceTrace:
    time_s = np.arange(6000) / 1000.0
    force_N = np.interp(time_s, [0.5, 2.5, 2.52, 4.5, 4.6], [0.0, 100.0, 80.0, 80.0, 0.0])
    noise_N = np.random.default_rng(12).normal(0.0, 0.05, time_s.size)
    return ForceTrace(time_s=time_s + start_s, force_N=scale * (force_N + noise_N))


def protocol_gives_results(protocol: Protocol) -> None:
    """Of a pull, a flat, a short and a noisy recording it gives one result or more; a force where the status is ok."""
    _must(protocol.measures in _MEASURES, f"measures is {protocol.measures!r}, none of {sorted(_MEASURES)}")
    _must(protocol.description, "there is no description")
    time_s = np.arange(500) / 1000.0
    recordings = {
        "a pull": _ramp(),
        "a flat recording": ForceTrace(time_s=time_s, force_N=np.zeros(500)),
        "four samples": ForceTrace(time_s=time_s[:4], force_N=np.array([0.0, 1.0, 2.0, 0.0])),
        "noise": ForceTrace(time_s=time_s, force_N=np.random.default_rng(13).normal(size=500)),
    }
    for what, trace in recordings.items():
        before = trace.force_N.copy()
        found: Any = protocol.pick(trace, PickSettings())
        right = isinstance(found, tuple) and found and all(isinstance(one, Breakaway) for one in found)
        _must(right, f"{what} gives {found!r:.60}, not a tuple of Breakaway")
        _must(np.array_equal(trace.force_N, before), f"{what} is changed")
        for one in found:
            _must(one.status is not Status.OK or np.isfinite(one.peak_N), f"{what}: ok without a force")
    flat = protocol.pick(recordings["a flat recording"], PickSettings())
    _must(all(one.status is not Status.OK for one in flat), "a flat recording gives a force")


def protocol_knows_no_clock_and_no_unit(protocol: Protocol) -> None:
    """The same pull an hour later gives the same force, and one of twice the force twice as much."""
    first = [one.peak_N for one in protocol.pick(_ramp(), PickSettings())]
    later = [one.peak_N for one in protocol.pick(_ramp(start_s=3600.0), PickSettings())]
    double = [one.peak_N for one in protocol.pick(_ramp(scale=2.0), PickSettings())]
    _must(np.allclose(first, later, rtol=1e-9, equal_nan=True), f"{first} N becomes {later} N an hour later")
    twice = np.allclose(2.0 * np.array(first), double, rtol=1e-9, equal_nan=True)
    _must(twice, f"{first} N doubled is {double} N")


# ---- readers and machines: with a file of their own ----


def reader_refuses_garbage(reader: Reader) -> None:
    """What is no recording is refused in ropefric's words, never read and never a crash."""
    _must(reader.description, "there is no description")
    written = all(one.startswith(".") and one == one.lower() for one in reader.suffixes)
    _must(written, f"suffixes {reader.suffixes}")
    with TemporaryDirectory() as folder:
        for what, content in _GARBAGE.items():
            path = Path(folder, f"garbage{(*reader.suffixes, '.dat')[0]}")
            path.write_bytes(content)
            profile = ImportProfile(format=reader.name)
            _refused(lambda path=path, profile=profile: read_recordings(path, profile), RopefricError, what)  # type: ignore[misc]


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
    """A scene has an answer of finite numbers that JSON can hold, twice the same, and a plan that explains it."""
    scene = load_scene(path)
    _must(scene.kind is kind, f"the scene is one of {scene.kind.name}")
    first, again = (json.dumps(solve_scene(scene).to_dict(), allow_nan=False) for _ in range(2))
    _must(first == again, "two answers to one scene differ")
    found = {one.name: one.value for one in solve_scene(scene).quantities}
    _must(found and all(np.isfinite(value).all() for value in found.values()), f"the answer is {found}")
    explain_scene(scene)


def kind_is_swept(kind: Kind, path: Path) -> None:
    """A sweep over each number that can be swept gives what the scene by itself gives there."""
    scene = load_scene(path)
    alone = {one.name: float(one.value[0]) for one in solve_scene(scene).quantities}
    for key, becomes in kind.sweep_fields.items():
        values = getattr(scene.problem, becomes.field, None)
        if values is None or np.ndim(values) != 1:
            continue
        there = float(values[0]) / becomes.factor
        axis = Axis(key=key, values=np.array([there, 1.001 * there]), unit="", factor=1.0)
        found = sweep_scene(scene, (axis,)).columns
        for name, value in alone.items():
            same = name not in found or np.isclose(found[name][0], value, rtol=1e-9, equal_nan=True)
            _must(same, f"over {key}, {name} is {found.get(name, [np.nan])[0]:.8g}, not {value:.8g}")


CHECKS: dict[str, tuple[Callable[[Any], None], ...]] = {
    "LAW": (
        law_is_declared_whole, law_takes_many_sets, law_lift_and_jacobian_agree, law_jacobian_is_the_derivative,
        law_gradient_by_conditions_is_the_derivative, law_grows_with_wrap_and_load, law_needs_wrap_to_hold,
        law_local_and_average_belong_together, law_guess_finds_clean_truth, law_guess_survives_poor_data,
        law_refuses_bad_parameters, law_is_finite_or_refuses, law_is_fitted_and_stored,
    ),
    "RULE": (
        rule_keeps_what_cannot_be_judged, rule_needs_finite_values, rule_knows_no_order_and_no_unit,
        rule_says_when_it_can_reject,
    ),
    "PROTOCOL": (protocol_gives_results, protocol_knows_no_clock_and_no_unit),
    "READER": (reader_refuses_garbage,),
    "KIND": (kind_is_declared_whole,),
}  # fmt: skip
"""What a member of each registry promises."""

FILE_CHECKS: dict[str, tuple[Callable[[Any, Path], None], ...]] = {
    "READER": (reader_reads,),
    "KIND": (kind_answers, kind_is_swept),
}
"""What can only be seen on a file: a recording for a reader, a scene for a machine."""


def check_plugin(source: str | Path, files: tuple[Path, ...] = ()) -> tuple[Plugin, tuple[Finding, ...]]:
    """Load a plugin and return which promises its members keep; `files` are recordings and scenes of its kind."""
    plugin = load_plugin(source)
    findings: list[Finding] = []
    for said in plugin.declares:
        slot, name = said.split(" ", 1)
        member = registry_of(slot)[name]
        findings += [_tried(said, check, member) for check in CHECKS.get(slot, ())]
        mine = [path for path in files if (path.suffix == ".toml") == (slot == "KIND")]
        findings += [
            _tried(said, check, member, path) for check in FILE_CHECKS.get(slot, ()) for path in mine
        ]
    return plugin, tuple(findings)


def _tried(said: str, check: Callable[..., None], member: Any, *paths: Path) -> Finding:
    promise = (check.__doc__ or "").strip()
    try:
        with np.errstate(all="ignore"):
            check(member, *paths)
    except PromiseError as broken:
        return Finding(member=said, promise=promise, broken=str(broken))
    except Exception as error:  # noqa: BLE001  (whatever a plugin does, it is told)
        return Finding(member=said, promise=promise, broken=f"{type(error).__name__}: {error}")
    return Finding(member=said, promise=promise)

"""One recording, one break-away: the static peak just before the rope slides."""

from dataclasses import replace

import numpy as np

from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.loading import climb_to, flattened
from ropefric.traces.outcome import kinetic, peak_between, peak_result, phases_of
from ropefric.traces.prepare import Prepared, failed, prepare, too_short
from ropefric.traces.protocols.protocol import Protocol
from ropefric.traces.settings import PickSettings
from ropefric.traces.sliding import Sliding, sliding_after
from ropefric.traces.slips import DROP_SIGMAS, is_slip
from ropefric.traces.slow_break import SlowBreak, slow_break
from ropefric.traces.static_break import first_static_break
from ropefric.traces.trace import ForceTrace
from ropefric.traces.verdict import (
    is_quiet,
    saturation_detail,
    stuck_detail,
    unresolved_detail,
    was_let_down,
    without_break,
)


def pick_breakaway(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return the break-away of a recording in which the load is raised once until the rope slides."""
    prepared = prepare(trace, settings)
    return (too_short(trace, settings) if prepared is None else pick_prepared(trace, prepared, settings),)


def pick_prepared(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Return the break-away of a recording that is prepared already, see `pick_breakaway`."""
    rise_N = float(prepared.view.force_N.max() - prepared.view.force_N[0])
    if rise_N <= 2 * smallest_drop_N(prepared, settings):
        return failed(Status.NO_BREAKAWAY, _flat_detail(prepared, rise_N), prepared)
    if settings.ending == "separation":
        return _before_separation(trace, prepared, settings)
    return _before_sliding(trace, prepared, settings)


def smallest_drop_N(prepared: Prepared, settings: PickSettings) -> float:
    """Return the smallest drop of the block means that may be more than noise [N]."""
    return max(DROP_SIGMAS * prepared.view.noise_N, 0.5 * (settings.min_step_N or 0.0))


def _flat_detail(prepared: Prepared, rise_N: float) -> str:
    if float(prepared.view.force_N[0] - prepared.view.force_N.min()) > 10 * max(rise_N, prepared.noise_N):
        return 'the force only goes down: a pull that reads negative needs [import.derived] force = "-…"'
    return (
        f"the force rises by {rise_N:.3g} N only, with {prepared.noise_N:.3g} N of noise on a sample: "
        "the recording shows no loading"
    )


def _before_sliding(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Find the static peak of a recording that goes on to slide."""
    view = prepared.view
    block = first_static_break(view, smallest_drop_N(prepared, settings))
    sliding = None if block is None else sliding_after(view, block)
    if hidden := _hidden(trace, prepared, block, sliding):
        return hidden
    if block is None:
        return without_break(prepared)
    if sliding is None:
        return _fell_away(prepared, block)
    if not is_slip(view, block) and flattened(view.force_N, climb_to(view.force_N, block)):
        return without_break(prepared, block)
    no_slip = _no_slip(prepared, block, sliding, settings)
    slow = slow_break(view, block)
    if slow is not None and slow.drop_N >= (settings.min_step_N or 0.0) and (no_slip or slow.outlasts_slip):
        return _broke_slowly(prepared, block, slow, settings)
    if no_slip is None and slow is None and not is_slip(view, block):
        no_slip = _no_evidence(prepared, block, sliding)
    return no_slip or _measured(prepared, block, sliding, settings)


def _hidden(
    trace: ForceTrace, prepared: Prepared, block: int | None, sliding: Sliding | None
) -> Breakaway | None:
    """Say why the converter did not show the peak; None if it did, or nothing broke away."""
    if saturated := saturation_detail(trace, prepared, block):
        return failed(Status.SATURATED, saturated, prepared)
    if block is None:
        return None
    stuck = stuck_detail(prepared, block, sliding.first if sliding else block + 1)
    return failed(Status.NO_PEAK, stuck, prepared) if stuck else None


def _broke_slowly(prepared: Prepared, block: int, slow: SlowBreak, settings: PickSettings) -> Breakaway:
    """Measure the peak before a fall that is slower than a slip, and say so."""
    note = (
        f"the force falls by {slow.drop_N:.3g} N within {1000 * slow.fall_s:.2g} ms, slower than a slip, and stays "
        f"at {slow.share:.0%} of the peak: a break-away, unless the motor was let back at that moment"
    )
    noted = replace(prepared, notes=(*prepared.notes, note))
    return _measured(noted, block, slow.sliding, settings)


def _no_evidence(prepared: Prepared, block: int, sliding: Sliding) -> Breakaway:
    """Say why a fall that is neither sudden nor followed by steady sliding is no break-away."""
    view = prepared.view
    detail = (
        f"the force falls from {view.force_N[block]:.4g} N to {sliding.onset_N:.4g} N slower than a rope slips, and "
        f"the recording ends {prepared.time_s[-1] - view.time_s[block]:.2g} s later"
    )
    return failed(Status.NO_BREAKAWAY, detail, prepared)


def _no_slip(prepared: Prepared, block: int, sliding: Sliding, settings: PickSettings) -> Breakaway | None:
    """Say what a break means that is no static peak; None if it is one."""
    if was_let_down(prepared, block, sliding):
        detail = (
            f"the force is let down from {prepared.view.force_N[block]:.4g} N to a quiet {sliding.level_N:.4g} N: "
            "the motor stopped before the rope slipped"
        )
        return failed(Status.NO_BREAKAWAY, detail, prepared)
    unresolved = unresolved_detail(prepared, block, sliding, settings)
    if not unresolved:
        return None
    if not is_slip(prepared.view, block) and is_quiet(prepared, block, sliding):
        detail = (
            f"the force stays at a quiet {sliding.level_N:.4g} N without a sudden drop: held, not slipping"
        )
        return failed(Status.NO_BREAKAWAY, detail, prepared)
    return _no_peak(prepared, block, sliding, unresolved)


def _before_separation(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Find the highest force of a recording that ends with the rope or specimen coming off."""
    force_N = prepared.view.force_N
    block = int(np.argmax(force_N))
    if hidden := _hidden(trace, prepared, block, None):
        return hidden
    after_N = float(force_N[block:].min())
    if float(force_N[block]) - after_N <= smallest_drop_N(prepared, settings):
        return without_break(prepared)
    return _measured(prepared, block, None, settings)


def _fell_away(prepared: Prepared, block: int) -> Breakaway:
    """Say what a force means that falls back without a stretch of sliding."""
    before = without_break(prepared, block)
    if before.status is Status.NO_PEAK:
        return before
    view = prepared.view
    detail = (
        f"the force falls from {view.force_N[block]:.4g} N at {view.time_s[block]:.4g} s without a stretch of "
        "sliding: motor stopped, or rope off. If these recordings end in a pull-off, set [protocol] ending = "
        '"separation".'
    )
    return failed(Status.NO_BREAKAWAY, detail, prepared)


def _no_peak(prepared: Prepared, block: int, sliding: Sliding, detail: str) -> Breakaway:
    kinetic_N, kinetic_std_N = kinetic(prepared, sliding)
    return Breakaway(
        status=Status.NO_PEAK,
        detail=detail,
        kinetic_N=kinetic_N,
        kinetic_std_N=kinetic_std_N,
        noise_std_N=prepared.noise_N,
        phases=phases_of(prepared, block, sliding),
        notes=prepared.notes,
    )


def _measured(prepared: Prepared, block: int, sliding: Sliding | None, settings: PickSettings) -> Breakaway:
    force_N = prepared.view.force_N
    peak = peak_between(
        prepared,
        settings,
        climb=climb_to(force_N, block).start,
        block=block,
        fallen=sliding.first if sliding else min(block + 2, force_N.size - 1),
    )
    return peak_result(prepared, peak, settings, sliding=sliding, phases=phases_of(prepared, block, sliding))


PROTOCOL = Protocol(
    name="breakaway",
    description="one load ramp a recording; F_A is the static peak before sliding",
    pick=pick_breakaway,
)

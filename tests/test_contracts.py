"""What we ask of plugins, our own members keep; and a member that breaks a promise is found out."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from ropefric import contracts
from ropefric.friction.laws import LAWS
from ropefric.friction.laws.uniform import Uniform
from ropefric.plugins import registry_of
from ropefric.scenes.scene import load_scene
from ropefric.traces.protocols import PROTOCOLS
from ropefric.traces.readers.table import Reader, Table
from ropefric.trials.outliers import RULES

SCENES = sorted((Path(__file__).parents[1] / "data" / "scenes").glob("*.toml"))
SLOW = {"press-start-up", "fast-band-saw"}
OURS = [
    pytest.param(check, member, id=f"{member.name}-{check.__name__}")
    for slot in ("RULE", "PROTOCOL", "READER", "KIND")  # laws: tests/friction
    for member in registry_of(slot).values()
    for check in contracts.CHECKS[slot]
]


@pytest.mark.parametrize(("check", "member"), OURS)
def test_our_own_keep_their_promises(check, member):
    check(member)


@pytest.mark.parametrize("check", contracts.FILE_CHECKS["KIND"], ids=lambda check: check.__name__)
@pytest.mark.parametrize(
    "path", [pytest.param(p, id=p.stem, marks=[pytest.mark.slow] * (p.stem in SLOW)) for p in SCENES]
)
def test_our_own_machines_answer(check, path):
    check(load_scene(path).kind, path)


def test_our_own_reader_reads(tmp_path):
    path = tmp_path / "pull.csv"
    path.write_text("time_s,force_N\n0,1\n0.1,2\n0.2,3\n", encoding="utf-8")
    contracts.reader_reads(registry_of("READER")["delimited"], path)
    path.write_text("time_s,force_N\n0,1\n0.2,2\n0.1,3\n", encoding="utf-8")
    with pytest.raises((contracts.PromiseError, ValueError)):
        contracts.reader_reads(registry_of("READER")["delimited"], path)


@dataclass(frozen=True)
class Bent(Uniform):
    """Euler's law with something wrong."""

    slope: float = 1.0
    by_wrap: float = 1.0
    lost: float = 0.0

    def mu_slopes(self, _columns, _conditions):
        return (np.array(self.slope),)

    def rise(self, columns, conditions):
        return super().rise(columns, conditions) - self.lost

    def condition_slopes(self, columns, conditions):
        by_radius, by_wrap, by_load = super().condition_slopes(columns, conditions)
        return by_radius, self.by_wrap * by_wrap, by_load


CONSTANT = LAWS["constant"]
BROKEN_LAWS = {
    "law_jacobian_is_the_derivative": replace(CONSTANT, physics=Bent(slope=1.00001)),
    "law_gradient_by_conditions_is_the_derivative": replace(CONSTANT, physics=Bent(by_wrap=0.99999)),
    "law_local_and_average_belong_together": replace(CONSTANT, physics=Bent(by_wrap=1.01)),
    "law_grows_with_wrap_and_load": replace(CONSTANT, physics=Bent(lost=1.0)),
    "law_needs_wrap_to_hold": replace(CONSTANT, physics=Bent(lost=-0.3)),
    "law_is_declared_whole": replace(CONSTANT, effects=frozenset({"magic"})),
    "law_guess_finds_clean_truth": replace(CONSTANT, physics=Bent(slope=-1.0), candidates=lambda *_: [[0.0]]),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN_LAWS)
def test_a_broken_law_is_found_out(name):
    check = next(check for check in contracts.CHECKS["LAW"] if check.__name__ == name)
    check(CONSTANT)
    finding = contracts._tried("LAW broken", check, BROKEN_LAWS[name])
    assert finding.broken
    assert finding.promise.endswith(".")


TWO_SIGMA = RULES["two-sigma"]
BROKEN_RULES = {
    "rule_knows_no_order_and_no_unit": lambda d: np.arange(d.size) == 0,
    "rule_keeps_what_cannot_be_judged": lambda d: np.ones(d.size, bool),
    "rule_says_when_it_can_reject": lambda d: np.abs(d - d.mean()) > 0.5 * d.std(),
}


@pytest.mark.parametrize("name", BROKEN_RULES)
def test_a_broken_rule_is_found_out(name):
    check = next(check for check in contracts.CHECKS["RULE"] if check.__name__ == name)
    assert contracts._tried("RULE", check, replace(TWO_SIGMA, judge=BROKEN_RULES[name])).broken


def test_a_broken_protocol_is_found_out():
    ours = PROTOCOLS["breakaway"]
    lists = replace(ours, pick=lambda trace, settings: list(ours.pick(trace, settings)))
    with pytest.raises(contracts.PromiseError, match="not a tuple of Breakaway"):
        contracts.protocol_gives_results(lists)
    counted = replace(
        ours,
        pick=lambda trace, how: tuple(replace(one, peak_N=one.peak_N + 1) for one in ours.pick(trace, how)),
    )
    with pytest.raises(contracts.PromiseError, match="doubled"):
        contracts.protocol_knows_no_clock_and_no_unit(counted)
    clocked = replace(
        ours,
        pick=lambda trace, how: tuple(
            replace(one, peak_N=one.peak_N + trace.time_s[0]) for one in ours.pick(trace, how)
        ),
    )
    with pytest.raises(contracts.PromiseError, match="an hour later"):
        contracts.protocol_knows_no_clock_and_no_unit(clocked)


def test_a_reader_that_reads_everything_is_found_out():
    """In the registry, because the check goes through the door that recordings go through."""
    from ropefric.plugins import unloaded_after
    from ropefric.traces.readers import READERS

    def tables(source, profile):
        arrays = [np.arange(5.0), np.arange(5.0)]
        return [
            Table(
                names=("time", "force"), units=("s", "N"), values=lambda wanted: [arrays[i] for i in wanted]
            )
        ]

    reader = Reader(name="credulous", suffixes=(".any",), description="everything", tables=tables)
    with unloaded_after():
        READERS.add(reader)
        with pytest.raises(contracts.PromiseError, match="an empty file is not refused"):
            contracts.reader_refuses_garbage(reader)

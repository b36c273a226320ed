"""What we ask of plugins, our own members keep; and a member that breaks a promise is found out."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from ropefric import testing
from ropefric.friction.laws import LAWS
from ropefric.friction.laws.uniform import Uniform
from ropefric.plugins import registry_of
from ropefric.scenes.scene import load_scene
from ropefric.traces.protocols import PROTOCOLS
from ropefric.traces.readers.table import Reader, Table
from ropefric.trials.outliers import RULES

SCENES = sorted((Path(__file__).parents[1] / "data" / "scenes").glob("*.toml"))
SLOW = {"press-start-up", "fast-band-saw"}


def test_our_own_keep_their_promises():  # laws: tests/friction
    for slot, check in (("RULE", testing.check_outlier_rule), ("PROTOCOL", testing.check_protocol),
                        ("READER", testing.check_reader), ("KIND", testing.check_scene_kind)):  # fmt: skip
        for member in registry_of(slot).values():
            check(member)


@pytest.mark.parametrize(
    "path", [pytest.param(p, id=p.stem, marks=[pytest.mark.slow] * (p.stem in SLOW)) for p in SCENES]
)
def test_our_own_machines_answer_and_are_swept(path):
    testing.check_scene_kind(load_scene(path).kind, path)


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


RECORDING = "time_s,force_N\n0,1\n0.1,2\n0.2,3\n"
BREAKAWAY = PROTOCOLS["breakaway"]


def picks(force_N, kind=tuple):
    """A protocol that gives another force than ours: `force_N(peak_N, start_s)`."""

    def pick(trace, settings):
        found = BREAKAWAY.pick(trace, settings)
        return kind(replace(one, peak_N=force_N(one.peak_N, float(trace.time_s[0]))) for one in found)

    return replace(BREAKAWAY, pick=pick)


def judges(judge):
    return replace(RULES["two-sigma"], judge=judge, can_reject=lambda _: True)


def reads_all(source, profile):
    values = lambda wanted: [np.arange(5.0) for _ in wanted]  # noqa: E731
    return [Table(names=("time", "force"), units=("s", "N"), values=values)]


@pytest.mark.parametrize(
    ("check", "member", "words"),
    [
        (testing.check_law, {"physics": Bent(slope=1.00001)}, "the slope by mu is"),
        (testing.check_law, {"physics": Bent(by_wrap=0.99999)}, "the slope by wrap_angle_rad is"),
        (testing.check_law, {"physics": Bent(lost=1.0)}, "is below F_B"),
        (testing.check_law, {"effects": frozenset({"magic"})}, "unknown effects .*magic"),
        (testing.check_law, {"physics": Bent(lost=-0.3)}, "a wrap of 1e-6 rad still lifts"),
        (testing.check_outlier_rule, judges(lambda d: np.arange(d.size) == 0), "loses a value|the order"),
        (testing.check_outlier_rule, judges(lambda d: np.ones(d.size, bool)), "loses a value"),
        (testing.check_outlier_rule, judges(lambda d: d > 0.5), "matters"),
        (testing.check_protocol, picks(lambda peak_N, _: peak_N, kind=list), "not a tuple of Breakaway"),
        (testing.check_protocol, picks(lambda peak_N, _: peak_N + 1.0), "doubled is"),
        (testing.check_protocol, picks(lambda peak_N, start_s: peak_N + start_s), "an hour later is"),
        (testing.check_reader, Reader(name="credulous", suffixes=(".any",), description="all", tables=reads_all),
         "is not refused"),
    ],
)  # fmt: skip
def test_a_broken_one_is_found_out(check, member, words):
    broken = replace(LAWS["constant"], **member) if isinstance(member, dict) else member
    with pytest.raises(testing.PromiseError, match=words):
        check(broken)


def test_a_reader_reads_what_it_says(tmp_path):
    path = tmp_path / "pull.csv"
    path.write_text(RECORDING, encoding="utf-8")
    testing.check_reader(registry_of("READER")["delimited"], path)
    path.write_text(RECORDING.replace("0.1", "0.3"), encoding="utf-8")
    with pytest.raises((testing.PromiseError, ValueError)):
        testing.check_reader(registry_of("READER")["delimited"], path)

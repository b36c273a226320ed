"""Excitations against modes: crossings, margins, and the preload that keeps away from them."""

from dataclasses import replace

import numpy as np
import pytest
from paper import whole

from ropefric.errors import InputError
from ropefric.systems.bandsaw.answer import frequencies_Hz
from ropefric.systems.bandsaw.resonance import (
    StrainStatus,
    find_crossings,
    fixed_frequency,
    margins,
    modes_over,
    recommend_preload,
    tooth_passing,
    wheel_rotation,
)
from ropefric.systems.bandsaw.saw import Side

T, S = Side.TIGHT, Side.SLACK


def test_excitations_are_what_passes_in_a_second():
    v = 35.552
    assert float(wheel_rotation(0.35).frequencies_Hz(v)[0]) == pytest.approx(970 / 60, rel=1e-4)
    assert tooth_passing(0.04, (1, 2)).frequencies_Hz(v).tolist() == pytest.approx([v / 0.04, 2 * v / 0.04])
    assert fixed_frequency("fan", 49.0, (1, 3)).frequencies_Hz([0.0, v]).tolist() == [
        [49.0, 147.0],
        [49.0, 147.0],
    ]


@pytest.mark.parametrize("bends", [False, True])
@pytest.mark.parametrize("kappa", [0.0, 1.0])
def test_at_a_crossing_mode_and_excitation_agree(saw, stiffness, bends, kappa):
    stiff = replace(saw, bending_stiffness_N_m2=stiffness if bends else 0.0, mounting_factor=kappa)
    excitations = (wheel_rotation(0.35), fixed_frequency("fan", 24.0))
    found = find_crossings(whole(stiff), S, excitations, np.linspace(0.0, 70.0, 8), 2)
    for crossing in found:
        at = frequencies_Hz(whole(stiff), S, 2, speed_m_s=crossing.speed_m_s)[0, crossing.mode - 1]
        assert at == pytest.approx(crossing.frequency_Hz, rel=1e-8)
        assert crossing.speed_margin == pytest.approx(crossing.speed_m_s / saw.speed_m_s[0] - 1)
    assert [crossing.speed_m_s for crossing in found] == sorted(crossing.speed_m_s for crossing in found)
    # Each pair at most once, and every pair whose order the speed range turns round.
    pairs = {(crossing.mode, crossing.excitation, crossing.harmonic) for crossing in found}
    assert len(pairs) == len(found)
    ends = frequencies_Hz(whole(stiff), S, 2, speed_m_s=[0.0, 70.0])
    turned = {(mode + 1, excitation.name, harmonic) for excitation in excitations
              for h, harmonic in enumerate(excitation.harmonics) for mode in range(2)
              if ends[0, mode] > excitation.frequencies_Hz(0.0)[h]
              and ends[1, mode] <= excitation.frequencies_Hz(70.0)[h]}  # fmt: skip
    assert pairs == turned
    assert found


def test_a_string_meets_its_wheel_where_algebra_says(saw):
    """n (c² − v²)/(2lc) = h v/(2πR) is quadratic in v for fixed axles."""
    still = replace(saw, tension_difference_N=0.0)
    c = float(np.sqrt(saw.preload_N / saw.linear_density_kg_m)[0])
    for crossing in find_crossings(whole(still), T, (wheel_rotation(0.35),), [0.0, 60.0], 3):
        a = crossing.harmonic * saw.free_span_m[0] * c / (crossing.mode * np.pi * 0.35)
        assert crossing.speed_m_s == pytest.approx(-0.5 * a + np.hypot(0.5 * a, c), rel=1e-11)


def test_margins_of_the_paper_saw(saw):
    found = margins(whole(saw), (T, S), (wheel_rotation(0.35, (1, 2)),), 3)
    assert len(found) == 12
    nearest = found[0]
    assert (nearest.side, nearest.mode, nearest.harmonic) == (S, 1, 1)
    assert nearest.margin == pytest.approx(17.9564 / 16.1667 - 1, abs=1e-5)
    assert [abs(margin.margin) for margin in found] == sorted(abs(margin.margin) for margin in found)
    assert margins(whole(replace(saw, wheel_speed_rad_s=0.0)), (T,), (wheel_rotation(0.35),), 3) == ()


def nearest(saw, excitations, preload, n_modes):
    found = margins(whole(replace(saw, preload_N=preload)), (T, S), excitations, n_modes)
    return min(abs(margin.margin) for margin in found)


@pytest.mark.parametrize("bends", [False, True])
def test_the_recommended_preload_is_the_nearest_that_keeps_the_margin(saw, stiffness, bends):
    stiff = replace(saw, bending_stiffness_N_m2=stiffness if bends else 0.0)
    excitations, n_modes = (wheel_rotation(0.35, (1, 2)),), 2
    found = recommend_preload(
        whole(stiff), excitations, margin=0.15, range_N=(2500.0, 7000.0), n_modes=n_modes
    )
    assert found.status is StrainStatus.CHANGE
    assert found.margin == pytest.approx(0.15, rel=1e-6)
    assert nearest(stiff, excitations, found.preload_N, n_modes) == pytest.approx(0.15, rel=1e-6)
    # By trying: everything nearer to the present preload is too near to an excitation.
    for preload in np.linspace(saw.preload_N[0], found.preload_N, 5)[:-1]:
        assert nearest(stiff, excitations, float(preload), n_modes) < 0.15
    kept = recommend_preload(whole(replace(stiff, preload_N=found.preload_N * 1.001)), excitations, margin=0.15,
                             range_N=(2500.0, 7000.0), n_modes=n_modes)  # fmt: skip
    assert kept.status is StrainStatus.KEEP
    assert kept.preload_N == found.preload_N * 1.001


def test_what_cannot_be_had_is_refused_with_the_best_there_is(saw):
    excitations = (wheel_rotation(0.35, (1, 2, 3)),)
    found = recommend_preload(whole(saw), excitations, margin=0.3, range_N=(2500.0, 6000.0), n_modes=3)
    assert found.status is StrainStatus.IMPOSSIBLE
    assert "No preload in the range keeps the margin" in found.status.advice
    assert found.margin < 0.3
    # By a dense search: no other preload is better, and this one is where it says.
    dense = np.linspace(2500.0, 6000.0, 70_001)
    of_modes = np.hstack([frequencies_Hz(whole(saw), side, 3, preload_N=dense) for side in (T, S)])
    excited = excitations[0].frequencies_Hz(saw.speed_m_s[0])
    margin = np.abs(of_modes[..., np.newaxis] / excited - 1.0).min(axis=(1, 2))
    assert margin.max() <= found.margin * (1.0 + 1e-6)
    assert found.margin == pytest.approx(margin.max(), rel=1e-3)
    assert found.preload_N == pytest.approx(dense[np.argmax(margin)], abs=0.1)
    assert found.margin == pytest.approx(nearest(saw, excitations, found.preload_N, 3), rel=1e-9)


def test_an_excitation_that_meets_no_mode_inside_the_range_forbids_no_end_of_it(saw, stiffness):
    for bends in [False, True]:
        for excitations in [(), (fixed_frequency("far off", 1e4),), (wheel_rotation(0.35, (1,)),)]:
            stiff = replace(saw, bending_stiffness_N_m2=stiffness if bends else 0.0, preload_N=6500.0)
            found = recommend_preload(
                whole(stiff), excitations, margin=0.01, range_N=(6000.0, 7000.0), n_modes=1
            )
            assert found.status is StrainStatus.KEEP, (bends, excitations)
            assert found.preload_N == 6500.0, (bends, excitations)


def test_refusals(saw):
    once = (wheel_rotation(0.35),)
    with pytest.raises(InputError, match=r"critical speed is 76\.7"):
        find_crossings(whole(saw), T, once, [10.0, 90.0])
    with pytest.raises(InputError, match="critical speed"):
        recommend_preload(whole(saw), once, margin=0.3, range_N=(500.0, 6000.0))


@pytest.mark.parametrize(("what", "ends"), [("speed_m_s", (0.0, 88.0)), ("preload_N", (700.0, 9000.0))])
def test_frequencies_over_a_range_are_those_of_the_blade_at_every_place(saw, stiffness, what, ends):
    stiff = replace(saw, bending_stiffness_N_m2=40.0 * stiffness, mounting_factor=0.3)
    curve, at = modes_over(whole(stiff), S, 5, what, ends=ends), np.linspace(*ends, 23)
    exact = frequencies_Hz(whole(stiff), S, 5, **{what: at}, accuracy=1e-12)
    assert exact[:, 0].max() > 4.0 * exact[:, 0].min(), "the range comes near to the critical speed"
    assert np.abs(curve(at) / exact - 1.0).max() <= 1e-9


def test_a_preload_at_the_edge_of_what_is_forbidden_is_decided(saw, stiffness):
    def advice_at(saw):
        once = (wheel_rotation(0.35, (1, 2)),)
        return recommend_preload(whole(saw), once, margin=0.15, range_N=(2500.0, 7000.0), n_modes=2)

    stiff = replace(saw, bending_stiffness_N_m2=stiffness)
    edge_N = advice_at(stiff).preload_N
    for off, status in ((-1e-8, StrainStatus.CHANGE), (1e-8, StrainStatus.KEEP)):
        assert advice_at(replace(stiff, preload_N=edge_N * (1.0 + off))).status is status

"""What the measured frequencies say: deviations, impossible mountings, and identification with honest errors."""

from dataclasses import replace

import numpy as np
import pytest

from ropefric.errors import InputError, UnknownNameError
from ropefric.systems.bandsaw.measured import (
    IdentificationStatus,
    Measurement,
    MountingStatus,
    deviation,
    explain_mounting,
    identify,
)
from ropefric.systems.bandsaw.saw import MODELS, Side, frequencies_Hz

T, S, R = Side.TIGHT, Side.SLACK, Side.REST


@pytest.fixture(scope="module")
def measured(machine):
    return {side: Measurement(side=side, frequency_Hz=machine[f"measured_{side}"]) for side in (R, T, S)}


def test_deviations_of_the_paper(saw, measured):
    found = {
        (model, side): deviation(saw, measured[side], model)[1]
        for model in ("string-constant-force", "string-fixed-axles")
        for side in (T, S)
    }
    wanted = {
        ("string-constant-force", T): -0.126,
        ("string-constant-force", S): -0.028,
        ("string-fixed-axles", T): -0.243,
        ("string-fixed-axles", S): -0.169,
    }
    for key, relative in wanted.items():
        assert found[key] == pytest.approx(relative, abs=5e-4)
    assert deviation(saw, measured[R], "string-at-rest")[1] == pytest.approx(0.0, abs=2e-3)


def test_no_mounting_explains_the_measured_frequencies(saw, stiffness, measured):
    tight, slack = (explain_mounting(saw, measured[side]) for side in (T, S))
    assert tight.mounting_factor == pytest.approx(2.21, abs=5e-3)
    assert slack.mounting_factor == pytest.approx(1.22, abs=5e-3)
    assert tight.status is slack.status is MountingStatus.TOO_HIGH
    assert "No mounting explains the frequency" in tight.status.advice
    # Stiffness explains the slack side's excess nearly, the tight side's by no means.
    stiff = replace(saw, bending_stiffness_N_m2=stiffness)
    tight, slack = (explain_mounting(stiff, measured[side]) for side in (T, S))
    assert 1.0 < slack.mounting_factor < 1.1
    assert tight.mounting_factor > 2.0


@pytest.mark.parametrize("bends", [False, True])
@pytest.mark.parametrize("kappa", [-0.4, 0.0, 0.37, 1.0, 2.5])
def test_the_explaining_mounting_is_the_one_that_was_there(saw, stiffness, bends, kappa):
    """Also outside [0, 1], where its tension is put into the preload."""
    stiff = replace(saw, bending_stiffness_N_m2=stiffness if bends else 0.0)
    more_N = kappa * saw.linear_density_kg_m * saw.speed_m_s**2
    frequency = float(frequencies_Hz(stiff, S, 2, preload_N=saw.preload_N + more_N)[0, 1])
    found = explain_mounting(stiff, Measurement(side=S, frequency_Hz=frequency, mode=2))
    assert found.mounting_factor == pytest.approx(kappa, abs=1e-8)
    if kappa not in {0.0, 1.0}:
        wanted = MountingStatus.EXPLAINED if 0 < kappa < 1 else None
        wanted = wanted or (MountingStatus.TOO_LOW if kappa < 0 else MountingStatus.TOO_HIGH)
        assert found.status is wanted


def points(saw, preload, kappa, *, sides=(R, T, S), modes=(1, 2, 3), speeds=(20.0, 35.0, 50.0), noise=None):
    truth = replace(saw, preload_N=preload, mounting_factor=kappa)
    made = []
    for side in sides:
        for speed in speeds if side is not R else (0.0,):
            exact = frequencies_Hz(truth, side, max(modes), speed_m_s=speed)[0]
            for mode in modes:
                off, std = (0.0, None) if noise is None else (noise[0].normal(0, noise[1]), noise[1])
                frequency = float(exact[mode - 1]) + off
                made.append(
                    Measurement(side=side, frequency_Hz=frequency, mode=mode, speed_m_s=speed, std_Hz=std)
                )
    return made


@pytest.mark.parametrize("bends", [False, True])
def test_exact_points_give_the_truth(saw, stiffness, bends):
    stiff = replace(saw, bending_stiffness_N_m2=stiffness if bends else 0.0, preload_N=1.0)
    given = points(stiff, 3900.0, 0.4, sides=(R, S), modes=(1, 2), speeds=(20.0, 50.0))
    found = identify(stiff, given)
    assert found.status is IdentificationStatus.OK
    assert found.preload_N == pytest.approx(3900.0, rel=1e-8)
    assert found.mounting_factor == pytest.approx(0.4, abs=1e-7)
    assert found.dof == 4
    assert np.abs(found.residual_Hz).max() < 1e-6
    assert not found.residual_Hz.flags.writeable


@pytest.mark.slow
@pytest.mark.parametrize("known", [True, False])
def test_errors_are_honest(saw, known):
    """Pulls of 50 repetitions: mean 0, spread 1."""
    rng = np.random.default_rng(7)
    pulls = []
    for _ in range(50):
        given = points(saw, 3412.0, 0.5, modes=(1, 2), speeds=(25.0, 45.0), noise=(rng, 0.1))
        if not known:
            given = [point._replace(std_Hz=None) for point in given]
        found = identify(saw, given)
        assert found.status is IdentificationStatus.OK
        std = found.std
        pulls.append([(found.preload_N - 3412.0) / std[0], (found.mounting_factor - 0.5) / std[1]])
    pulls = np.array(pulls)
    # Standard errors of a mean and a spread of 50 numbers, times three.
    assert (np.abs(pulls.mean(axis=0)) < 3 / np.sqrt(50)).all()
    assert (np.abs(pulls.std(axis=0) - 1.0) < 3 / np.sqrt(100) * (1.0 if known else 1.3)).all()


def test_the_covariance_is_that_of_the_jacobian(saw):
    given = points(saw, 3412.0, 0.5, noise=(np.random.default_rng(1), 0.1))
    found = identify(saw, given)
    F, k = found.preload_N, found.mounting_factor

    def model(preload, kappa):
        changed = replace(saw, preload_N=preload, mounting_factor=kappa)
        return np.array(
            [frequencies_Hz(changed, p.side, p.mode, speed_m_s=p.speed_m_s)[0, -1] for p in given]
        )

    jacobian = np.stack(
        [(model(F + 1, k) - model(F - 1, k)) / 2, (model(F, k + 1e-4) - model(F, k - 1e-4)) / 2e-4], axis=1
    )
    np.testing.assert_allclose(found.covariance, np.linalg.inv(jacobian.T @ jacobian) * 0.01, rtol=1e-5)


def test_the_measured_frequencies_of_the_paper_ask_for_more_than_any_mounting_has(saw, measured):
    # Printed to a tenth of a hertz: a standard uncertainty of 0.1/√12 Hz.
    given = [point._replace(std_Hz=0.03) for point in measured.values()]
    found = identify(saw, given)
    assert found.status is IdentificationStatus.BEYOND_BOUND
    assert "no mounting has" in found.status.advice
    assert found.mounting_factor == 1.0
    assert found.free_mounting_factor > 1.5
    assert found.dof == 2
    assert found.covariance[1].tolist() == [0.0, 0.0]
    # Nothing that fits all three: one is missed by more than a hertz.
    assert np.abs(found.residual_Hz).max() > 1.0
    # By their own scatter about the model the points say less, and the preload hardly anything.
    blind = identify(saw, list(measured.values()))
    assert blind.mounting_factor == 1.0
    assert blind.std[0] > 30 * found.std[0]


def test_a_constant_force_mounting_lies_on_the_bound_or_within_and_is_none_beyond(saw):
    rng = np.random.default_rng(3)
    statuses = [
        identify(saw, points(saw, 3412.0, 1.0, modes=(1, 2), speeds=(25.0, 45.0), noise=(rng, 0.1))).status
        for _ in range(24)
    ]
    on_bound = statuses.count(IdentificationStatus.ON_BOUND)
    assert 5 <= on_bound <= 19
    assert statuses.count(IdentificationStatus.BEYOND_BOUND) <= 3


def test_a_wrong_mode_is_a_misfit(saw):
    given = points(saw, 3412.0, 0.5, noise=(np.random.default_rng(2), 0.1))
    assert identify(saw, given).status is IdentificationStatus.OK
    given[2] = given[2]._replace(frequency_Hz=given[2].frequency_Hz + 2.0)
    assert identify(saw, given).status is IdentificationStatus.MISFIT


@pytest.mark.parametrize("kappa", [-0.3, 1.4])
def test_beyond_both_bounds_the_free_answer_is_told(saw, kappa):
    more_N = kappa * saw.linear_density_kg_m * np.array([0.0, 20.0, 40.0]) ** 2
    given = [
        Measurement(
            side=T if speed else R, speed_m_s=speed,
            frequency_Hz=float(
                frequencies_Hz(saw, T if speed else R, 1, speed_m_s=speed, preload_N=3412.0 + more)[0, 0]
            ),
        )
        for speed, more in zip((0.0, 20.0, 40.0), more_N, strict=True)
    ]  # fmt: skip
    found = identify(saw, given)
    assert found.status is IdentificationStatus.BEYOND_BOUND
    assert found.mounting_factor == (1.0 if kappa > 1 else 0.0)
    assert found.free_mounting_factor == pytest.approx(kappa, abs=1e-5)


def test_what_cannot_be_told_is_not_told(saw):
    still = [Measurement(side=R, frequency_Hz=23.6), Measurement(side=R, frequency_Hz=47.3, mode=2)]
    found = identify(saw, still)
    assert found.status is IdentificationStatus.UNIDENTIFIABLE
    assert found.covariance is None
    assert found.std is None
    assert found.preload_N == pytest.approx(3412.0, rel=0.01)
    one_speed = points(saw, 3412.0, 0.5, sides=(T,), speeds=(35.0,))
    assert identify(saw, one_speed).status is IdentificationStatus.UNIDENTIFIABLE
    exactly = identify(saw, points(saw, 3412.0, 0.5, sides=(T,), modes=(1,), speeds=(0.0, 35.0)))
    assert exactly.status is IdentificationStatus.NO_SPARE
    assert exactly.covariance is None
    assert exactly.dof == 0
    known = points(
        saw, 3412.0, 0.5, sides=(T,), modes=(1,), speeds=(0.0, 35.0), noise=(np.random.default_rng(0), 0.01)
    )
    assert identify(saw, known).status is IdentificationStatus.OK


@pytest.mark.parametrize("status", [*IdentificationStatus, *MountingStatus])
def test_every_status_is_advice(status):
    assert status.advice[0].isupper()
    assert status.advice.endswith(".")


def test_models_leave_out_what_they_say(saw, stiffness):
    stiff = replace(saw, bending_stiffness_N_m2=stiffness, mounting_factor=0.3)
    for name, model in MODELS.items():
        made = replace(stiff, **model.changes)
        assert (made.speed_m_s > 0) == ("at-rest" not in name)
        assert made.bending_stiffness_N_m2 == (stiffness if name.startswith("beam") else 0.0)
        assert made.mounting_factor == (1.0 if name.endswith("constant-force") else 0.0)
    measured = Measurement(side=T, frequency_Hz=24.9)
    assert deviation(stiff, measured, "beam-constant-force")[0] == pytest.approx(22.28, abs=5e-3)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda saw: explain_mounting(saw, Measurement(side=R, frequency_Hz=1.0)), InputError, "stood still"),
        (
            lambda saw: deviation(saw, Measurement(side=T, frequency_Hz=1.0), "beam-fixed-axles"),
            InputError,
            "no bending stiffness",
        ),
        (
            lambda saw: deviation(saw, Measurement(side=T, frequency_Hz=1.0), "string-fixed-axle"),
            UnknownNameError,
            "did you mean 'string-fixed-axles'",
        ),
        (lambda saw: identify(saw, [Measurement(side=T, frequency_Hz=1.0)]), InputError, "1 points"),
        (
            lambda saw: identify(
                saw,
                [Measurement(side=T, frequency_Hz=20.0), Measurement(side=R, frequency_Hz=20.0, std_Hz=1.0)],
            ),
            InputError,
            "some points have an uncertainty",
        ),
    ],
)
def test_refusals(saw, call, error, words):
    with pytest.raises(error, match=words):
        call(saw)

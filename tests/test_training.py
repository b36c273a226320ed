"""Making the picker's weights again: the same lessons for the same seed, and weights that say what was trained."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs the extra `train`")

from ropefric import training  # noqa: E402
from ropefric.rig.stories import draw_recording  # noqa: E402
from ropefric.traces import picker  # noqa: E402
from ropefric.traces.breakaway import Status  # noqa: E402


@pytest.fixture(scope="module")
def lessons():
    """Some forty lessons: whole recordings and closer looks."""
    made = []
    for number in range(24):
        rng = np.random.default_rng([1, number])
        made.extend(training.lessons_of(draw_recording(rng), rng))
    return made


def test_lessons_are_the_same_each_time_and_their_answer_lies_where_the_force_is_high(lessons):
    rng = np.random.default_rng([1, 3])
    (first, *_) = training.lessons_of(draw_recording(rng), rng)
    assert any(np.array_equal(first.channels, one.channels) for one in lessons)
    sure = [one for one in lessons if one.answer < picker.BINS]
    assert len(sure) > 10
    for one in sure:
        at = int(one.answer)
        near = one.channels[max(0, at - 2) : at + 3, 0].max()
        assert near >= one.channels[max(0, at - 40) : at + 1, 0].max() - 0.1
    reasons = {picker.REASONS[int(one.answer) - picker.BINS] for one in lessons if one.answer >= picker.BINS}
    assert Status.NO_BREAKAWAY in reasons


def test_weights_in_numpy_say_what_the_trained_network_says(lessons):
    arrays = (
        np.array([one.channels for one in lessons], dtype=np.float16),
        np.array([one.answer for one in lessons], dtype=np.float32),
        np.array([one.states for one in lessons], dtype=np.uint8),
    )
    said = []
    network = training.train(arrays, 102, 1, said.append)
    assert len(said) == 1
    weights = picker.multiplied(
        {**network.weights(), "temperature": 1.0, "rarer": np.zeros(len(picker.REASONS))}
    )
    assert sum(values.size for values in weights.values()) < 500_000
    one = draw_recording(np.random.default_rng(5))
    seen = picker.look(one.time_s, one.force_N, weights)
    channels, _ = picker.seen(one.time_s, one.force_N)
    with torch.no_grad():
        logits, _ = network(torch.from_numpy(channels.T[None].astype(np.float32)))
    share = torch.softmax(logits[0].double(), dim=0).numpy()
    np.testing.assert_allclose(seen.place, share[: picker.BINS], atol=0.01)
    np.testing.assert_allclose(list(seen.reasons.values()), share[picker.BINS :], atol=0.02)

"""Whatever the files hold, there is an answer: a campaign, or a RopefricError with the same text every time."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ropefric.errors import RopefricError
from ropefric.trials.campaign import check_campaign, load_campaign

FOLDER = Path(__file__).parent / "good"
GOOD, TRIALS = ((FOLDER / name).read_text(encoding="utf-8") for name in ("campaign.toml", "trials.csv"))

quick = settings(
    max_examples=60,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


def answers(bench):
    """Load and check agree, and say the same when asked again."""
    problems = check_campaign(bench.path)
    assert problems == check_campaign(bench.path)
    errors = tuple(p for p in problems if p.severity == "error")
    for problem in problems:
        assert problem.message
        assert "validation error" not in problem.message
        assert "something else" not in problem.message
    if errors:
        with pytest.raises(RopefricError) as caught:
            load_campaign(bench.path)
        assert caught.value.problems == errors
        assert caught.value.exit_code == 3
    else:
        campaign = load_campaign(bench.path)
        assert campaign.resolved()
        assert len(campaign.settings_fingerprint()) == 64


def mutated(text):
    """Good text with a few pieces cut, doubled, moved or replaced."""
    junk = st.sampled_from(
        [
            "",
            '"',
            "'",
            "[",
            "]",
            "=",
            "\n",
            "#",
            "{}",
            "[]",
            "1",
            "-1",
            "nan",
            "inf",
            "true",
            '"x"',
            "0xffff",
            "1e400",
            "1979-05-27",
            ";",
            ",",
            "\t",
            "\x00",
            "é",
            "\ufeff",
            "*",
            "9" * 40,
            "_",
            ".",
            "%",
        ]
    )
    place = st.integers(0, len(text))
    edits = st.lists(st.tuples(place, st.integers(0, 12), junk), min_size=1, max_size=5)

    def apply(changes):
        result = text
        for at, cut, new in changes:
            result = result[:at] + new + result[at + cut :]
        return result

    return edits.map(apply)


values = st.recursive(
    st.sampled_from(
        [
            "1",
            "-1",
            "0.5",
            "nan",
            "inf",
            "true",
            '""',
            '"x"',
            '"1 mm"',
            '"1e400 m"',
            "1979-05-27",
            "07:32:00",
            "0xffffffffffffffffffffffffffffff",
            '"1 %"',
            '"9 9**9**9"',
            '"\\u0000"',
        ]
    ),
    lambda inner: (
        st.lists(inner, max_size=3).map(lambda xs: f"[{', '.join(xs)}]")
        | st.lists(inner, max_size=2).map(
            lambda xs: "{" + ", ".join(f"k{i} = {x}" for i, x in enumerate(xs)) + "}"
        )
    ),
    max_leaves=4,
)
LINES = [number for number, line in enumerate(GOOD.splitlines()) if " = " in line]


@quick
@given(text=mutated(GOOD))
def test_spoilt_campaign_files(bench, text):
    bench.write(toml=text)
    answers(bench)


@quick
@given(changes=st.lists(st.tuples(st.sampled_from(LINES), values), min_size=1, max_size=4))
def test_any_value_for_any_key(bench, changes):
    lines = GOOD.splitlines()
    for number, value in changes:
        lines[number] = lines[number].split(" = ")[0] + " = " + value
    bench.write(toml="\n".join(lines))
    answers(bench)


@quick
@given(text=st.text(max_size=200) | st.binary(max_size=200))
def test_any_text_as_campaign_file(bench, text):
    bench.write(toml=text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass"))
    answers(bench)


@quick
@given(text=mutated(TRIALS))
def test_spoilt_tables(bench, text):
    bench.write(toml=GOOD, trials=text)
    answers(bench)


@quick
@given(content=st.binary(max_size=200) | st.text("a,;\t\"'#\n\r1.-_ éN", max_size=100).map(str.encode))
def test_any_bytes_as_table(bench, content):
    bench.write(toml=GOOD, trials=content)
    answers(bench)
    bench.write(trials=TRIALS.encode() + content)
    answers(bench)


@quick
@given(
    header=st.lists(
        st.sampled_from([*TRIALS.split("\n")[0].split(","), "wrap_turns", "from_s", "sample", "x (y)"]),
        max_size=9,
    ),
    cells=st.lists(
        st.lists(
            st.sampled_from(["", "a.csv", "40", "-1", "1e300", "1e-300", "W40", "K1", "*", "0,5", "x"]),
            max_size=9,
        ),
        max_size=4,
    ),
    mark=st.sampled_from(",;\t"),
)
def test_any_columns_and_cells(bench, header, cells, mark):
    bench.write(toml=GOOD, trials="\n".join(mark.join(row) for row in [header, *cells]))
    answers(bench)


@pytest.mark.parametrize("key", ["trials", "data"])
@pytest.mark.parametrize("name", ["", ".", "..", "/", "\\u0000", "n" * 300, "~", "*", "recordings/a.csv/x"])
def test_odd_names_of_files_and_folders(bench, key, name):
    bench.spoil(rf'^{key}( +)= ".*"', f'{key} = "{name}"'.replace("\\", "\\\\"), pattern=True)
    answers(bench)

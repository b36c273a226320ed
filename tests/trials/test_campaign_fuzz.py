"""Whatever the files hold there is an answer: a campaign, or a RopefricError; tests/fuzz spoils more."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ropefric.errors import RopefricError
from ropefric.trials.campaign import check_campaign, load_campaign

FOLDER = Path(__file__).parent / "good"
GOOD, TRIALS = ((FOLDER / name).read_text(encoding="utf-8") for name in ("campaign.toml", "trials.csv"))
HEADER = [*TRIALS.split("\n")[0].split(","), "wrap_turns", "from_s", "sample", "x (y)"]
LINES = [number for number, line in enumerate(GOOD.splitlines()) if " = " in line]
quick = settings(max_examples=24, deadline=None, suppress_health_check=[*HealthCheck])


def answers(bench):
    """Load and check agree, and say the same when asked again."""
    problems = check_campaign(bench.path)
    errors = tuple(p for p in problems if p.severity == "error")
    for problem in problems:
        assert problem.message
        assert "validation error" not in problem.message
        assert "something else" not in problem.message
    if errors:
        with pytest.raises(RopefricError) as caught:
            load_campaign(bench.path)
        assert (caught.value.problems, caught.value.exit_code) == (errors, 3)
    else:
        campaign = load_campaign(bench.path)
        assert campaign.resolved()
        assert len(campaign.settings_fingerprint()) == 64


JUNK = [*"\"'[]=#;,*_.%é\x00\ufeff\n\t", "", "{}", "[]", "1", "-1", "nan", "inf", "true", '"x"', "9" * 40]
JUNK += ["0xffff", "1e400", "1979-05-27"]
VALUES = ["1", "-1", "0.5", "nan", "inf", "true", '""', '"x"', "1979-05-27", "07:32:00", "0x" + "f" * 30]
VALUES += ['"1 mm"', '"1e400 m"', '"1 %"', '"9 9**9**9"', '"\\u0000"']
CELLS = ["", "a.csv", "40", "-1", "1e300", "1e-300", "W40", "K1", "*", "0,5", "x"]


def mutated(text):
    """Good text with a few pieces cut, doubled, moved or replaced."""
    edit = st.tuples(st.integers(0, len(text)), st.integers(0, 12), st.sampled_from(JUNK))

    def apply(changes):
        result = text
        for at, cut, new in changes:
            result = result[:at] + new + result[at + cut :]
        return result

    return st.lists(edit, min_size=1, max_size=5).map(apply)


def inline(inner):
    arrays = st.lists(inner, max_size=3).map(lambda xs: f"[{', '.join(xs)}]")
    tables = st.lists(inner, max_size=2).map(lambda xs: ", ".join(f"k{i} = {x}" for i, x in enumerate(xs)))
    return arrays | tables.map("{{ {} }}".format)


values = st.recursive(st.sampled_from(VALUES), inline, max_leaves=4)


@quick
@given(text=st.text(max_size=200) | st.binary(max_size=200))
def test_any_campaign_file(bench, text):
    bench.write(toml=text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass"))
    answers(bench)


@quick
@given(changes=st.lists(st.tuples(st.sampled_from(LINES), values), min_size=1, max_size=4))
def test_any_value_for_any_key(bench, changes):
    lines = GOOD.splitlines()
    for number, value in changes:
        lines[number] = lines[number].split(" = ")[0] + " = " + value
    bench.write(toml="\n".join(lines))
    answers(bench)


rows = st.lists(st.sampled_from(HEADER),
    max_size=9).flatmap(lambda header: st.lists(st.lists(st.sampled_from(CELLS), max_size=9),
    max_size=4).map(lambda rows: [header, *rows]))  # fmt: skip


@quick
@given(content=mutated(TRIALS).map(str.encode) | st.binary(max_size=200) | st.text("a,;\t\"'#\n\r1.-_ éN",
    max_size=100).map(str.encode) | st.tuples(rows,
    st.sampled_from(",;\t")).map(lambda x: "\n".join(map(x[1].join, x[0])).encode()), after=st.booleans()
)  # fmt: skip
def test_spoilt_and_any_tables(bench, content, after):
    bench.write(toml=GOOD, trials=TRIALS.encode() * after + content)
    answers(bench)


@pytest.mark.parametrize("key", ["trials", "data"])
def test_odd_names_of_files_and_folders(bench, key):
    for name in ("", ".", "..", "/", "\\u0000", "n" * 300, "~", "*", "recordings/a.csv/x"):
        bench.write(toml=GOOD)
        bench.spoil(rf'^{key}( +)= ".*"', f'{key} = "{name}"'.replace("\\", "\\\\"), pattern=True)
        answers(bench)

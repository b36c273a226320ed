"""Campaign files and lists with pieces moved, doubled, replaced, or anything at all: a campaign, or errors in words."""

from pathlib import Path

from fuzz_kit import HOSTILE, answered, fuzzed, scratch, usable
from hypothesis import strategies as st

from ropefric.errors import DataError
from ropefric.trials.campaign import check_campaign, load_campaign

GOOD = Path(__file__).parents[1] / "trials" / "good"
TOML, TRIALS = ((GOOD / name).read_text(encoding="utf-8") for name in ("campaign.toml", "trials.csv"))
LINES = TOML.splitlines()
KEYS = [number for number, line in enumerate(LINES) if " = " in line]
JUNK = ("", *"\"'[]=#;,*_.%\t\n", "[[x]]", "{}", "[]", "-1", "nan", "inf", "true", '"x"', "0xffff", "1e400",
    "1979-05-27", "07:32:00", "\x00", "é", "9" * 400, '"1 mm"', '"1 %"', '"1e400 m"', '"-1 N"', '"1 N/s"', "'''",
    "[a.b.c]", "a.b = 1", "[1, [true]]", '{ k0 = 1, k1 = "x" }', *HOSTILE)  # fmt: skip
NAMES = ("", ".", "..", "/", "\\u0000", "n" * 300, "~", "*", "recordings/a.csv/x")
CELLS = ("", "a.csv", "40", "-1", "1e300", "1e-300", "W40", "K1", "*", "0,5", "x")
HEADER = (*TRIALS.split("\n")[0].split(","), "wrap_turns", "from_s", "sample", "x (y)")
FOLDER = scratch()
(FOLDER / "recordings").mkdir()
for _name in "abc":
    (FOLDER / "recordings" / f"{_name}.csv").write_text("time_s,counts\n", encoding="utf-8")


def judge(toml=TOML, trials=TRIALS):
    """The two ways to look at a campaign agree, and what is wrong is told with its place."""
    path = FOLDER / "campaign.toml"
    for name, content in ((path.name, toml), ("trials.csv", trials)):
        data = content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass")
        (FOLDER / name).write_bytes(data)
    problems = check_campaign(path)
    errors = tuple(problem for problem in problems if problem.severity == "error")
    for problem in problems:
        assert len(problem.message) > 10
        assert not any(one in problem.message for one in ("validation error", "something else"))
    if errors:
        usable(DataError(errors[0].message, problems=errors))
    refused = []
    campaign = answered(lambda: load_campaign(path), refused)
    assert (campaign is None) == bool(refused) == bool(errors)
    assert not errors or errors[0].message in refused[0]
    if campaign is not None:
        assert campaign.resolved()
        assert campaign.settings()
        assert campaign.trials
        for trial in campaign.trials:
            assert trial.wheel_radius_m > 0.0
            assert trial.rope_radius_m > 0.0
            assert trial.wrap_angle_rad >= 0.0


def edited(text, edits):
    for place, cut, junk in edits:
        at = place % (len(text) + 1)
        text = text[:at] + junk + text[at + cut :]
    return text


def check_campaign_file(moves, values, edits):
    """A good file whose lines are moved, doubled, removed, given other values, and cut."""
    lines = list(LINES)
    for source, target, how in moves:
        one, other = KEYS[source % len(KEYS)], KEYS[target % len(KEYS)]
        key, value = lines[one].split(" = ", 1) if " = " in lines[one] else (lines[one], "1")
        if how == "value":
            lines[one] = f"{key} = {lines[other].split(' = ', 1)[-1]}"
        elif how == "twice":
            lines[other] = f"{lines[other]}\n{key} = {value}"
        elif how == "gone":
            lines[one] = ""
        elif how == "moved":
            lines[one], lines[other] = lines[other], lines[one]
    for place, value in values:
        one = KEYS[place % len(KEYS)]
        lines[one] = f"{lines[one].split(' = ')[0]} = {value}"
    judge(edited("\n".join(lines), edits))


def check_list(edits, rows, mark, after):
    """A good list with pieces cut and replaced, any columns and cells, alone or below a good list."""
    any_table = "\n".join(mark.join(row) for row in rows)
    judge(trials=TRIALS * after + any_table if rows else edited(TRIALS, edits))


EDITS = st.lists(st.tuples(st.integers(0, 3000), st.integers(0, 15), st.sampled_from(JUNK)), max_size=3)
test_campaigns, test_campaigns_long = fuzzed(check_campaign_file, short=50, share=0.006, edits=EDITS,
    moves=st.lists(st.tuples(st.integers(0, 99), st.integers(0, 99),
    st.sampled_from(["value", "value", "twice", "gone", "moved"])), max_size=3),
    values=st.lists(st.tuples(st.integers(0, 99), st.sampled_from(JUNK)), max_size=2))  # fmt: skip
test_lists, test_lists_long = fuzzed(check_list, short=30, share=0.004, edits=EDITS,
    rows=st.lists(st.lists(st.sampled_from(HEADER), max_size=9), max_size=1).flatmap(lambda head: st.lists(
    st.lists(st.sampled_from(CELLS), max_size=9), max_size=4).map(lambda rows: head and [*head, *rows])),
    mark=st.sampled_from(",;\t"), after=st.booleans())  # fmt: skip
test_any_file, test_any_file_long = fuzzed(judge, short=20, share=0.002,
    toml=st.text(max_size=200) | st.binary(max_size=200) | st.just(TOML),
    trials=st.binary(max_size=200) | st.text("a,;\t\"'#\n\r1.-_ éN", max_size=100))  # fmt: skip


def test_odd_names_of_files_and_folders():
    for key in ("trials", "data"):
        (line,) = (line for line in LINES if line.startswith(f"{key} ") and " = " in line)
        for name in NAMES:
            judge(TOML.replace(line, f'{line.split(" = ")[0]} = "{name}"'))

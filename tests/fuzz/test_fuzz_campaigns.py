"""Campaign files with lines moved, doubled and given each other's values; tests/trials does the rest."""

from pathlib import Path

from fuzz_kit import HOSTILE, answered, fuzzed, scratch, usable
from hypothesis import strategies as st

from ropefric.errors import DataError
from ropefric.trials.campaign import check_campaign, load_campaign

GOOD = Path(__file__).parents[1] / "trials" / "good"
LINES = GOOD.joinpath("campaign.toml").read_text(encoding="utf-8").splitlines()
TRIALS = GOOD.joinpath("trials.csv").read_bytes()
KEYS = [number for number, line in enumerate(LINES) if " = " in line]
JUNK = ("", '"', "[", "]", "[[x]]", "=", "{}", "[]", "-1", "nan", "inf", "true", '"x"', "0xffff", "1e400",
    "1979-05-27", "\x00", "é", "9" * 400, '"1 mm"', '"1e400 m"', '"-1 N"', '"1 N/s"', "'''", "#", "[a.b.c]",
    "a.b = 1", *HOSTILE)  # fmt: skip
FOLDER = scratch()
(FOLDER / "recordings").mkdir()
for _name in "abc":
    (FOLDER / "recordings" / f"{_name}.csv").write_text("time_s,counts\n", encoding="utf-8")
(FOLDER / "trials.csv").write_bytes(TRIALS)


def check_campaign_file(moves, edits):
    """The two ways to look at a campaign agree, and what is wrong is told with its place."""
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
    text = "\n".join(lines)
    for place, cut, junk in edits:
        at = place % (len(text) + 1)
        text = text[:at] + junk + text[at + cut :]
    path = FOLDER / "campaign.toml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    problems = check_campaign(path)
    errors = tuple(problem for problem in problems if problem.severity == "error")
    for problem in problems:
        assert len(problem.message) > 10
        assert "validation error" not in problem.message
    if errors:
        usable(DataError(errors[0].message, problems=errors))
    campaign = answered(lambda: load_campaign(path))
    assert (campaign is None) == bool(errors)
    if campaign is not None:
        assert campaign.trials
        for trial in campaign.trials:
            assert trial.wheel_radius_m > 0.0
            assert trial.rope_radius_m > 0.0
            assert trial.wrap_angle_rad >= 0.0


test_campaigns, test_campaigns_long = fuzzed(check_campaign_file, short=40, share=0.006,
    moves=st.lists(st.tuples(st.integers(0, 99), st.integers(0, 99),
    st.sampled_from(["value", "value", "twice", "gone", "moved"])), max_size=3),
    edits=st.lists(st.tuples(st.integers(0, 3000), st.integers(0, 15), st.sampled_from(JUNK)),
    max_size=2))  # fmt: skip

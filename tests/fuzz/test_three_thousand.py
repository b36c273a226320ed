"""3 000 damaged or hostile inputs: each ends in a result, a flagged trial or a clear refusal.

No traceback, no hang, no death of the process, and where a damaged recording comes out `ok`, its force is right: the
damages are such that the true force is known (or lost, and then no force may come out). Input n is made from n alone,
so a number in a failure is all that is needed to see it again: `python tests/fuzz/test_three_thousand.py 1234`.
Recordings in packed formats are read by libraries that may take the process with them; they have a process of their
own, with bounded memory and processor time.
"""

import copy
import gzip
import io
import json
import random
import subprocess
import sys
import tempfile
from functools import cache
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from fuzz_kit import answered, limit

from ropefric.cli.commands.laws import read_levels
from ropefric.cli.options import parse_assignments
from ropefric.errors import RopefricError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.store import load_fit, verify_fit
from ropefric.quantities import parse_any_quantity, parse_quantity, split_unit_suffix, unit_factor
from ropefric.scenes.scene import load_scene
from ropefric.scenes.solve import solve_scene
from ropefric.scenes.sweep import parse_axis
from ropefric.trials.campaign import check_campaign, load_campaign
from ropefric.trials.extract import extract_recording
from ropefric.trials.table import read_trial_table

ROOT = Path(__file__).parents[2]
N_INPUTS = 3000
SAMPLE = 62  # of which the default suite takes every so many
CHUNK = 250
TRUE_N, NEAR = 100.0, 0.025
HOSTILE = (
    "", "nan", "-inf", "1e300", "5e-324", "1e400", "9" * 5000, "-0", "1e-99999999999999999999", "١٢", "0x1F", "1_000",
    "1e300 mm", "1e300 Hz", "10**10**10 mm", "9**9**9**9", "1 " + "a" * 30 + "!",
    "9.8 Millimeterdurchmesserlaut-2019",
    "1 m" + "²" * 30, "_" * 20_000, "(" * 20_000, "a." * 20_000, "[" * 5000, "{a=" * 2000,
    '"', "'''", '"""', "\\", "\x00",
    "\x1b[31m", "\ufeff", "\u202e", "$\\frac{$", "=cmd|'/C calc'!A0", "+1", "@SUM(A1)", "-1+1",
    "../../x", "CON", "x" * 400,
    "%s%n", "{0}", "<script>", "&", "]]>", "NaN", "true", "null", "1979-05-27", "12:00",
    "1,5", "1.234,5", "1;2", "#", "\t", "\r",
)  # fmt: skip


def force_N(time_s):
    """A load, a rise to 100 N and a slide at 80 N."""
    return np.interp(time_s, [0.0, 0.3, 1.3, 1.32, 2.5], np.array([0, 0, 1.0, 0.8, 0.8]) * TRUE_N)


@cache
def recording():
    """Return the rows of a good recording as text, and the number of the row of its peak."""
    time_s = np.arange(750) / 300.0
    force = force_N(time_s) + 0.05 * np.random.default_rng(1).standard_normal(time_s.size)
    return tuple(f"{t:.4f},{f:.3f}" for t, f in zip(time_s, force, strict=True)), int(force.argmax())


HEAD = "time_s,force_N"


def cut(rng, lines, peak):
    text = "\n".join([HEAD, *lines, ""])
    return text[: rng.randrange(len(text))]


def cut_in_a_number(rng, lines, peak):
    keep = rng.randrange(2, len(lines))
    return "\n".join([HEAD, *lines[:keep], lines[keep][: -rng.randrange(1, 5)]])


def dropped(rng, lines, peak):
    gone = {rng.randrange(len(lines)) for _ in range(rng.randrange(1, 6))}
    return "\n".join([HEAD, *(line for place, line in enumerate(lines) if place not in gone), ""])


def dropped_block(rng, lines, peak):
    """A gap, with the peak and a tenth of a second about it still there."""
    size = rng.randrange(5, 60)
    start = rng.choice([rng.randrange(0, peak - 30 - size), rng.randrange(peak + 40, len(lines) - size)])
    return "\n".join([HEAD, *lines[:start], *lines[start + size :], ""])


def doubled(rng, lines, peak):
    start, size = rng.randrange(len(lines)), rng.choice([1, 1, 2, 30])
    return "\n".join([HEAD, *lines[: start + size], *lines[start:], ""])


def reordered(rng, lines, peak):
    lines, size = list(lines), rng.choice([1, 1, 5, 40])
    a, b = sorted(rng.sample(range(0, len(lines) - size, size), 2))
    lines[a : a + size], lines[b : b + size] = lines[b : b + size], lines[a : a + size]
    return "\n".join([HEAD, *lines, ""])


def zeroed(rng, lines, peak):
    data = bytearray("\n".join([HEAD, *lines, ""]).encode())
    start, size = rng.randrange(len(data)), rng.choice([1, 16, 512, 4096])
    data[start : start + size] = bytes(len(data[start : start + size]))
    return bytes(data)


def frozen(rng, lines, peak):
    """A converter that gives the same number again and again while the force goes over its peak."""
    start = rng.randrange(peak - 80, peak - 3)
    end = rng.randrange(peak + 3, peak + 120)
    held = lines[start].split(",")[1]
    mended = [
        f"{line.split(',')[0]},{held}" if start <= place < end else line for place, line in enumerate(lines)
    ]
    return "\n".join([HEAD, *mended, ""])


def stuck(rng, lines, peak):
    held = rng.choice([line.split(",")[1] for line in lines])
    start = rng.randrange(0, peak - 60)
    mended = [f"{line.split(',')[0]},{held}" if place >= start else line for place, line in enumerate(lines)]
    return "\n".join([HEAD, *mended, ""])


def separators(rng, lines, peak):
    start = rng.choice([0, rng.randrange(len(lines))])
    new = rng.choice([";", "\t", "|", " ", ", ", ",,"])
    return "\n".join(
        [HEAD, *(line.replace(",", new) if place >= start else line for place, line in enumerate(lines)), ""]
    )


def decimals(rng, lines, peak):
    lines = [line.replace(",", ";") for line in lines]
    start = rng.choice([0, rng.randrange(len(lines))])
    lines = [line.replace(".", ",") if place >= start else line for place, line in enumerate(lines)]
    return "\n".join([HEAD.replace(",", ";"), *lines, ""])


def line_ends(rng, lines, peak):
    return "".join(line + rng.choice(["\n", "\r\n", "\r\n", "\n\n"]) for line in [HEAD, *lines])


def mac_ends(rng, lines, peak):
    return "\r".join([HEAD, *lines, ""])


def marked(rng, lines, peak):
    text = "\n".join([HEAD, *lines, ""])
    return rng.choice([b"\xef\xbb\xbf" + text.encode(), text.encode("utf-16"), text.encode("utf-16-be"),
                       b"\xef\xbb\xbf\xef\xbb\xbf" + text.encode(), text.encode("utf-32")])  # fmt: skip


def header(rng, lines, peak):
    heads = ("", HEAD[: rng.randrange(len(HEAD))], HEAD.upper(), HEAD.replace(",", ""), "force_N", f"{HEAD},{HEAD}",
             "\x00",
             "time_s,force_N,", '"time_s,force_N', "time_s;force_N",
             "time (aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa!),force_N",
             "time_s,force (10**10**10 N)", "time_s,force " + "_" * 20_000, "time_s," + "(" * 20_000,
             "\x1b[2J,force_N",
             f"# {HOSTILE[rng.randrange(len(HOSTILE))]}\n{HEAD}", f"{HEAD}\n[s],[N]", f"{HEAD}\n\n\n")  # fmt: skip
    return "\n".join([rng.choice(heads), *lines, ""])


def second_header(rng, lines, peak):
    start = rng.randrange(len(lines))
    return "\n".join([HEAD, *lines[:start], HEAD, *lines[start:], ""])


def words(rng, lines, peak):
    """Cells that hold no number: nothing that could be taken for one."""
    lines = list(lines)
    for _ in range(rng.randrange(1, 4)):
        place = rng.randrange(len(lines))
        cells = lines[place].split(",")
        cells[rng.randrange(2)] = rng.choice(
            ["", "nan", "NaN", "ERR", "-", "#N/A", "=1+1", "1e400", "--", "\x1b[0m", "$x$", "é"]
        )
        lines[place] = ",".join(cells)
    return "\n".join([HEAD, *lines, ""])


def spoilt_gzip(rng, lines, peak):
    data = bytearray(gzip.compress("\n".join([HEAD, *lines, ""]).encode(), mtime=0))
    if rng.random() < 0.5:
        return bytes(data[: rng.randrange(len(data))])
    data[rng.randrange(len(data))] ^= rng.randrange(1, 256)
    return bytes(data)


TEXT_DAMAGES = (cut, cut, cut_in_a_number, dropped, dropped_block, doubled, reordered, zeroed, frozen, stuck,
                separators, decimals, line_ends, mac_ends, marked, header, header, second_header, words,
                spoilt_gzip)  # fmt: skip


@cache
def lab():
    """Return a folder with campaigns of one recording, by the suffix of its file."""
    folder = Path(tempfile.mkdtemp(prefix="ropefric-three-thousand-"))
    for suffix in ("csv", "csv.gz", "mat", "xlsx", "tdms"):
        (folder / f"{suffix}.toml").write_text(
            f'schema = "ropefric.campaign/1"\nname = "lab"\ntrials = "{suffix}-trials.csv"\n'
            '[rope]\ndiameter = "9.8 mm"\n',
            encoding="utf-8",
        )
        (folder / f"{suffix}-trials.csv").write_text(
            f"file,wheel_radius_mm,wrap_angle_deg,end_tension_N\nr.{suffix},40,180,20\n", encoding="utf-8"
        )
    return folder


def judge_recording(data, suffix, *, lost=False):
    """Extract one recording; a force that comes out is the true one."""

    folder = lab()
    (folder / f"r.{suffix}").write_bytes(data)
    campaign = load_campaign(folder / f"{suffix}.toml")
    results = extract_recording(campaign, list(campaign.trials))
    assert results
    for result in chain.from_iterable(results):
        json.dumps(result.to_dict(), allow_nan=False)
        if str(result.breakaway.status) == "ok":
            assert not lost, f"{result.peak_N} N from a recording without a force"
            assert abs(result.peak_N - TRUE_N) <= NEAR * TRUE_N, f"ok with {result.peak_N} N"
        else:
            assert result.breakaway.detail or result.problems


def text_recording(rng, number):
    damage = TEXT_DAMAGES[number % len(TEXT_DAMAGES)]
    lines, peak = recording()
    data = damage(rng, lines, peak)
    data = data if isinstance(data, bytes) else data.encode("utf-8", "surrogatepass")
    suffix = "csv.gz" if damage is spoilt_gzip or rng.random() < 0.15 else "csv"
    if suffix == "csv.gz" and damage is not spoilt_gzip:
        data = gzip.compress(data, mtime=0)
    judge_recording(data, suffix, lost=damage is stuck)


@cache
def packed(suffix):
    """Return a good recording in a packed format."""
    lines, _ = recording()
    time_s, force = np.array([[float(cell) for cell in line.split(",")] for line in lines]).T
    stream = io.BytesIO()
    if suffix == "mat":
        from scipy.io import savemat

        savemat(stream, {"time_s": time_s, "force_N": force}, do_compression=True)
    elif suffix == "xlsx":
        from openpyxl import Workbook

        book = Workbook()
        for row in [HEAD.split(","), *zip(time_s.tolist(), force.tolist(), strict=True)]:
            book.active.append(row)
        book.save(stream)
    else:
        from nptdms import ChannelObject, TdmsWriter

        with TdmsWriter(stream) as writer:
            writer.write_segment([ChannelObject("g", "time_s", time_s), ChannelObject("g", "force_N", force)])
    return stream.getvalue()


def packed_recording(rng, number):
    """Bytes cut, zeroed or flipped; what has no checksum may change numbers, so only the way it ends is judged."""
    suffix = ("mat", "xlsx", "tdms")[number % 3]
    data = bytearray(packed(suffix))
    how = rng.choice(["cut", "flip", "flip", "zero", "junk", "other"])
    at = rng.randrange(len(data)) if rng.random() < 0.5 else rng.randrange(min(400, len(data)))
    if how == "cut":
        del data[at:]
    elif how == "flip":
        for _ in range(rng.randrange(1, 6)):
            data[(at + rng.randrange(64)) % len(data)] ^= rng.randrange(1, 256)
    elif how == "zero":
        data[at : at + 64] = bytes(len(data[at : at + 64]))
    elif how == "junk":
        data[at:at] = rng.randbytes(rng.randrange(1, 64))
    else:
        data = bytearray(packed(rng.choice(["mat", "xlsx", "tdms"])))
    try:
        judge_recording(bytes(data), suffix)
    except AssertionError as error:
        if suffix != "tdms" or "ok with" not in str(error):
            raise


def garbled(rng, text, mark):
    """Return text with values replaced by hostile ones, lines moved, doubled, cut."""
    lines = text.splitlines()
    for _ in range(rng.randrange(1, 4)):
        at = rng.randrange(len(lines))
        how = rng.choice(["value", "value", "value", "quoted", "gone", "twice", "swap", "cut", "insert"])
        if how in {"value", "quoted"}:
            value = rng.choice(HOSTILE)
            cells = lines[at].split(mark)
            cells[rng.randrange(len(cells))] = json.dumps(value) if how == "quoted" else f" {value}"
            lines[at] = mark.join(cells)
        elif how == "gone":
            lines[at] = ""
        elif how == "twice":
            lines.insert(at, lines[at])
        elif how == "swap":
            other = rng.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        elif how == "cut":
            lines[at] = lines[at][: rng.randrange(len(lines[at]) + 1)]
        else:
            lines[at] = lines[at][:3] + rng.choice(HOSTILE) + lines[at][3:]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


@cache
def good_campaign():
    folder = Path(tempfile.mkdtemp(prefix="ropefric-three-thousand-"))
    source = ROOT / "tests" / "trials" / "good"
    for path in source.rglob("*"):
        target = folder / path.relative_to(source)
        if path.is_dir():
            target.mkdir()
        else:
            target.write_bytes(path.read_bytes())
    return folder


def campaign(rng, number):

    folder, source = good_campaign(), ROOT / "tests" / "trials" / "good"
    spoilt = ("campaign.toml", "trials.csv")[number % 2]
    for name, mark in (("campaign.toml", "="), ("trials.csv", ",")):
        text = (source / name).read_text(encoding="utf-8")
        (folder / name).write_bytes(garbled(rng, text, mark) if name == spoilt else text.encode())
    problems = check_campaign(folder / "campaign.toml")
    assert all(len(problem.message) > 10 and len(str(problem)) < 3000 for problem in problems)
    found = answered(lambda: load_campaign(folder / "campaign.toml", missing_recordings="warning"))
    assert found is None or found.trials


@cache
def good_table():
    rng = np.random.default_rng(3)
    rows = ["trial,wheel_radius_mm,rope_diameter_mm,wrap_angle_deg,end_tension_N,peak_N,kept,status"]
    for i in range(12):
        wrap = 180 * (1 + i % 4)
        peak = 20 * np.exp(0.2 * np.radians(wrap)) * (1 + 0.01 * rng.standard_normal())
        rows.append(f"t{i},{40 + 10 * (i % 3)},9.8,{wrap},20,{peak:.3f},true,ok")
    return "\n".join(rows)


def table(rng, number):

    path = lab() / "table.csv"
    path.write_bytes(garbled(rng, good_table(), ","))
    found = answered(lambda: read_trial_table(path))
    if found is not None:
        fit = answered(lambda: fit_law(found, "constant"))
        assert fit is None or json.dumps(fit.to_dict(), allow_nan=False)


def scene(rng, number):

    names = (
        "hoist",
        "climbing-hoist",
        "small-wheel",
        "many-turns",
        "hoist",
        "belt-press",
        "band-saw",
        "hoist",
    )
    text = (ROOT / "data" / "scenes" / f"{names[number % len(names)]}.toml").read_text(encoding="utf-8")
    path = lab() / "scene.toml"
    path.write_bytes(garbled(rng, text.replace("../../fits", (ROOT / "fits").as_posix()), "="))
    found = answered(lambda: load_scene(path))
    if found is not None:
        solved = answered(lambda: solve_scene(found))
        if solved is not None and found.kind.name == "hoist":
            json.dumps(solved.to_dict(), allow_nan=False)


@cache
def good_fit():
    return json.loads((ROOT / "fits" / "prth-constant.json").read_text(encoding="utf-8"))


def fit(rng, number):

    tree = copy.deepcopy(good_fit())
    inner, at = tree, None
    while isinstance(inner, dict | list) and inner:
        parent, at = inner, rng.choice(list(inner) if isinstance(inner, dict) else range(len(inner)))
        inner = parent[at]
        if rng.random() < 0.3:
            break
    parent[at] = rng.choice([None, [], {}, True, -1, 1e300, 10**400, "", *HOSTILE])
    text = json.dumps(tree)
    if number % 4 == 0:
        text = text[: rng.randrange(len(text))] + rng.choice(["", "]", "NaN", "[" * 5000])
    path = lab() / "fit.json"
    path.write_text(text, encoding="utf-8")
    answered(lambda: load_fit(path))
    found = verify_fit(path)
    assert len(found.message) > 10
    assert "Error" not in found.message, found.message


def flag(rng, number):

    text = rng.choice(["", "1", "1 ", "-1e3"]) + rng.choice(HOSTILE) + rng.choice(["", " mm", " N", "!"])
    unit = rng.choice(["m", "N", "rad", ""])
    loaded = load_scene(ROOT / "data" / "scenes" / "many-turns.toml")
    for read in (
        lambda: parse_quantity(text, unit), lambda: parse_any_quantity(text), lambda: unit_factor(text, unit),
        lambda: split_unit_suffix(text), lambda: parse_assignments([text, f"a={text}"], option="--x"),
        lambda: read_levels(f"{text} .. {text}", unit, "--x", 5), lambda: read_levels(text, unit, "--x", 5),
        lambda: parse_axis(loaded, f"wheel.wrap={text}"),
        lambda: parse_axis(loaded, f"wheel.wrap=1deg:{text}:{text}"),
    ):  # fmt: skip
        try:
            answered(read)
        except Exception as error:
            if type(error).__name__ != "BadParameter":  # typer's way to refuse an option
                raise


KINDS = ((0, text_recording), (1560, packed_recording), (1800, campaign), (2300, table), (2550, scene), (2750, fit),
         (2900, flag))  # fmt: skip


def one(number):
    """Make and judge input `number`."""
    kind = [judge for start, judge in KINDS if number >= start][-1]
    with limit(20):
        kind(random.Random(f"three thousand {number}"), number)


def faults(numbers):
    """Return what goes wrong among inputs, in words."""
    found = {}
    for number in numbers:
        try:
            one(number)
        except Exception as error:  # noqa: BLE001  (whatever it is, it is what we look for)
            code = error.code if isinstance(error, RopefricError) else ""
            found[number] = f"{type(error).__name__} {code} {error}"[:300]
    return found


def faults_apart(numbers):
    """The same in a process of its own, with 6 GB of addresses and ten minutes of processor at the most."""
    script = (
        "import resource, sys\n"
        "resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))\n"
        "resource.setrlimit(resource.RLIMIT_CPU, (600, 600))\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "import json, test_three_thousand as here\n"
        "for number in map(int, sys.argv[1:]):\n"
        "    print(number, json.dumps(here.faults([number])), flush=True)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", script, *map(str, numbers)],
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    told = [line.partition(" ") for line in ended.stdout.splitlines()]
    found = {int(number): fault for number, _, text in told for fault in json.loads(text).values()}
    if ended.returncode:
        died = list(numbers)[len(told)]
        found[died] = f"the process died ({ended.returncode}): {ended.stderr[-300:]}"
    return found


def is_packed(number):
    return KINDS[1][0] <= number < KINDS[2][0]


def check(numbers):
    found = faults(number for number in numbers if not is_packed(number))
    apart = [number for number in numbers if is_packed(number)]
    if apart:
        found |= faults_apart(apart)
    assert not found


def test_some_of_three_thousand():
    check(range(0, N_INPUTS, SAMPLE))


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, N_INPUTS, CHUNK))
def test_three_thousand(start):
    check(range(start, start + CHUNK))


if __name__ == "__main__":
    for asked in map(int, sys.argv[1:]):
        one(asked)

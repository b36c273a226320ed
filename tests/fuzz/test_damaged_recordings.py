"""1 800 damaged recordings, and hostile words: each ends in a result, a flagged trial or a clear refusal.

No traceback, no hang, no death of the process, and where a damaged recording comes out `ok`, its force is right: the
damages are such that the true force is known (or lost, and then no force may come out). Input n is made from n alone,
so a number in a failure is all that is needed to see it again: `python tests/fuzz/test_damaged_recordings.py 1234`.
Recordings in packed formats are read by libraries that may take the process with them; in the long run they have a
process of their own, with bounded memory and processor time.
"""

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
from fuzz_kit import HOSTILE, answered, fuzzed, limit
from hypothesis import strategies as st

from ropefric.cli.commands.laws import read_levels
from ropefric.cli.options import parse_assignments
from ropefric.errors import RopefricError
from ropefric.quantities import parse_any_quantity, parse_quantity, split_unit_suffix, unit_factor
from ropefric.scenes.scene import load_scene
from ropefric.scenes.sweep import parse_axis
from ropefric.trials.campaign import load_campaign
from ropefric.trials.extract import extract_recording

ROOT = Path(__file__).parents[2]
N_TEXTS, N_INPUTS = 1560, 1800
SAMPLE = 47  # of which the default suite takes every so many
CHUNK = 300
TRUE_N, NEAR = 100.0, 0.025
HEAD = "time_s,force_N"
WORDS = ("", "nan", "NaN", "ERR", "-", "#N/A", "=1+1", "1e400", "--", "\x1b[0m", "$x$", "é")
HEADS = ("", HEAD.upper(), HEAD.replace(",", ""), "force_N", f"{HEAD},{HEAD}", "\x00", "time_s,force_N,",
    '"time_s,force_N', "time_s;force_N", "time (aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa!),force_N",
    "time_s,force (10**10**10 N)", "time_s,force " + "_" * 20_000, "time_s," + "(" * 20_000,
    "\x1b[2J,force_N", f"{HEAD}\n[s],[N]", f"{HEAD}\n\n\n")  # fmt: skip


@cache
def recording():
    """A load, a rise to 100 N and a slide at 80 N: the rows as text, and the number of the row of the peak."""
    time_s = np.arange(750) / 300.0
    force_N = np.interp(time_s, [0.0, 0.3, 1.3, 1.32, 2.5], np.array([0, 0, 1.0, 0.8, 0.8]) * TRUE_N)
    force_N += 0.05 * np.random.default_rng(1).standard_normal(time_s.size)
    return tuple(f"{t:.4f},{f:.3f}" for t, f in zip(time_s, force_N, strict=True)), int(force_N.argmax())


def text(lines, head=HEAD):
    return "\n".join([head, *lines, ""])


def where(lines, change, start, end=None):
    """Return lines of which those from `start` on are changed."""
    end = len(lines) if end is None else end
    return [change(line) if start <= place < end else line for place, line in enumerate(lines)]


def held(value):
    return lambda line: f"{line.split(',')[0]},{value}"


def cut(rng, lines, peak):
    return text(lines)[: rng.randrange(len(text(lines)))]


def cut_in_a_number(rng, lines, peak):
    keep = rng.randrange(2, len(lines))
    return text([*lines[:keep], lines[keep][: -rng.randrange(1, 5)]])[:-1]


def dropped(rng, lines, peak):
    gone = {rng.randrange(len(lines)) for _ in range(rng.randrange(1, 6))}
    return text(line for place, line in enumerate(lines) if place not in gone)


def dropped_block(rng, lines, peak):
    """A gap, with the peak and a tenth of a second about it still there."""
    size = rng.randrange(5, 60)
    start = rng.choice([rng.randrange(0, peak - 30 - size), rng.randrange(peak + 40, len(lines) - size)])
    return text([*lines[:start], *lines[start + size :]])


def doubled(rng, lines, peak):
    start, size = rng.randrange(len(lines)), rng.choice([1, 1, 2, 30])
    return text([*lines[: start + size], *lines[start:]])


def reordered(rng, lines, peak):
    lines, size = list(lines), rng.choice([1, 1, 5, 40])
    a, b = sorted(rng.sample(range(0, len(lines) - size, size), 2))
    lines[a : a + size], lines[b : b + size] = lines[b : b + size], lines[a : a + size]
    return text(lines)


def zeroed(rng, lines, peak):
    data = bytearray(text(lines).encode())
    start, size = rng.randrange(len(data)), rng.choice([1, 16, 512, 4096])
    data[start : start + size] = bytes(len(data[start : start + size]))
    return bytes(data)


def frozen(rng, lines, peak):
    """A converter that gives the same number again and again while the force goes over its peak."""
    start, end = rng.randrange(peak - 80, peak - 3), rng.randrange(peak + 3, peak + 120)
    return text(where(lines, held(lines[start].split(",")[1]), start, end))


def stuck(rng, lines, peak):
    value = rng.choice(lines).split(",")[1]
    return text(where(lines, held(value), rng.randrange(0, peak - 60)))


def separators(rng, lines, peak):
    start, mark = rng.choice([0, rng.randrange(len(lines))]), rng.choice([";", "\t", "|", " ", ", ", ",,"])
    return text(where(lines, lambda line: line.replace(",", mark), start))


def decimals(rng, lines, peak):
    start, lines = rng.choice([0, rng.randrange(len(lines))]), [line.replace(",", ";") for line in lines]
    return text(where(lines, lambda line: line.replace(".", ","), start), HEAD.replace(",", ";"))


def line_ends(rng, lines, peak):
    return "".join(line + rng.choice(["\n", "\r\n", "\r\n", "\n\n"]) for line in [HEAD, *lines])


def mac_ends(rng, lines, peak):
    return text(lines).replace("\n", "\r")


def marked(rng, lines, peak):
    whole, mark = text(lines), b"\xef\xbb\xbf"
    codes = [whole.encode(code) for code in ("utf-16", "utf-16-be", "utf-32")]
    return rng.choice([mark + whole.encode(), mark + mark + whole.encode(), *codes])


def header(rng, lines, peak):
    return text(lines, rng.choice([*HEADS, HEAD[: rng.randrange(len(HEAD))],
        f"# {rng.choice(HOSTILE)}\n{HEAD}"]))  # fmt: skip


def second_header(rng, lines, peak):
    start = rng.randrange(len(lines))
    return text([*lines[:start], HEAD, *lines[start:]])


def words(rng, lines, peak):
    """Cells that hold no number: nothing that could be taken for one."""
    lines = list(lines)
    for _ in range(rng.randrange(1, 4)):
        place = rng.randrange(len(lines))
        cells = lines[place].split(",")
        cells[rng.randrange(2)] = rng.choice(WORDS)
        lines[place] = ",".join(cells)
    return text(lines)


def spoilt_gzip(rng, lines, peak):
    data = bytearray(gzip.compress(text(lines).encode(), mtime=0))
    if rng.random() < 0.5:
        return bytes(data[: rng.randrange(len(data))])
    data[rng.randrange(len(data))] ^= rng.randrange(1, 256)
    return bytes(data)


DAMAGES = (cut, cut, cut_in_a_number, dropped, dropped_block, doubled, reordered, zeroed, frozen, stuck,
    separators, decimals, line_ends, mac_ends, marked, header, header, second_header, words,
    spoilt_gzip)  # fmt: skip


@cache
def lab(suffix):
    """Return a campaign of one recording of this kind, whose file is written anew for every input."""
    folder = Path(tempfile.mkdtemp(prefix="ropefric-damaged-"))
    (folder / "campaign.toml").write_text(
        'schema = "ropefric.campaign/1"\nname = "lab"\ntrials = "trials.csv"\nrope = { diameter = "9.8 mm" }\n'
    )
    (folder / "trials.csv").write_text(
        f"file,wheel_radius_mm,wrap_angle_deg,end_tension_N\nr.{suffix},40,180,20\n"
    )
    (folder / f"r.{suffix}").write_bytes(b"")
    return folder / f"r.{suffix}", load_campaign(folder / "campaign.toml")


def judge(data, suffix, *, lost=False):
    """Extract one recording; a force that comes out is the true one."""
    path, campaign = lab(suffix)
    path.write_bytes(data)
    results = extract_recording(campaign, list(campaign.trials))
    assert results
    for result in chain.from_iterable(results):
        json.dumps(result.to_dict(), allow_nan=False)
        if str(result.breakaway.status) == "ok":
            assert not lost, f"{result.peak_N} N from a recording without a force"
            assert abs(result.peak_N - TRUE_N) <= NEAR * TRUE_N, f"ok with {result.peak_N} N"
        else:
            assert result.breakaway.detail or result.problems


def judge_text(rng, number):
    damage = DAMAGES[number % len(DAMAGES)]
    data = damage(rng, *recording())
    data = data if isinstance(data, bytes) else data.encode("utf-8", "surrogatepass")
    packed = damage is not spoilt_gzip and rng.random() < 0.15
    suffix = "csv.gz" if packed or damage is spoilt_gzip else "csv"
    judge(gzip.compress(data, mtime=0) if packed else data, suffix, lost=damage is stuck)


@cache
def good(suffix):
    """Return a good recording in a packed format."""
    time_s, force_N = np.array([line.split(",") for line in recording()[0]], dtype=float).T
    stream = io.BytesIO()
    if suffix == "mat":
        from scipy.io import savemat

        savemat(stream, {"time_s": time_s, "force_N": force_N}, do_compression=True)
    elif suffix == "xlsx":
        from openpyxl import Workbook

        book = Workbook()
        for row in [HEAD.split(","), *zip(time_s.tolist(), force_N.tolist(), strict=True)]:
            book.active.append(row)
        book.save(stream)
    else:
        from nptdms import ChannelObject, TdmsWriter

        with TdmsWriter(stream) as writer:
            writer.write_segment([ChannelObject("g", "time_s", time_s),
                ChannelObject("g", "force_N", force_N)])  # fmt: skip
    return stream.getvalue()


def judge_packed(rng, number):
    """Bytes cut, zeroed or flipped; what has no checksum may change numbers, so only the way it ends is judged."""
    suffix = ("mat", "xlsx", "tdms")[number % 3]
    data = bytearray(good(suffix))
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
        data = bytearray(good(rng.choice(["mat", "xlsx", "tdms"])))
    try:
        judge(bytes(data), suffix)
    except AssertionError as error:
        if suffix != "tdms" or "ok with" not in str(error):
            raise


def faults(numbers):
    """Return what goes wrong among inputs, in words."""
    found = {}
    for number in numbers:
        try:
            with limit(20):
                kind = judge_text if number < N_TEXTS else judge_packed
                kind(random.Random(f"damaged {number}"), number)
        except Exception as error:  # noqa: BLE001  (whatever it is, it is what we look for)
            code = error.code if isinstance(error, RopefricError) else ""
            found[number] = f"{type(error).__name__} {code} {error}"[:300]
    return found


def test_some_damaged_recordings():
    assert faults(range(0, N_INPUTS, SAMPLE)) == {}


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, N_TEXTS, CHUNK))
def test_texts(start):
    assert faults(range(start, min(start + CHUNK, N_TEXTS))) == {}


@pytest.mark.slow
def test_packed_recordings_in_a_process_of_their_own():
    """With 6 GB of addresses and ten minutes of processor at the most."""
    script = ("import resource, sys\nresource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))\n"
        "resource.setrlimit(resource.RLIMIT_CPU, (600, 600))\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\nimport test_damaged_recordings as here\n"
        "for number in range(here.N_TEXTS, here.N_INPUTS):\n"
        "    print(number, here.faults([number]), flush=True)\n")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=900,
        check=False)  # fmt: skip
    told = done.stdout.splitlines()
    assert [line for line in told if not line.endswith("{}")] == []
    assert (done.returncode, len(told)) == (0, N_INPUTS - N_TEXTS), done.stderr[-300:]


def check_anything(data, suffix):
    """Random bytes and random tables give no force."""
    judge(data, suffix, lost=True)


test_anything, test_anything_long = fuzzed(check_anything, short=30, share=0.01,
    data=st.binary(max_size=400) | st.text('0123456789.,;\t\n -+eEnaNif"_Ntime', max_size=400).map(str.encode)
    | st.text('0123456789.,;\t\n -+eEnaNif"_', max_size=400).map(lambda rows: f"{HEAD}\n{rows}".encode()),
    suffix=st.sampled_from(["csv", "csv", "csv", "csv.gz", "txt", "mat", "xlsx", "tdms"]))  # fmt: skip


def check_any_scale(scale, offset, stretch):
    """Units nobody thought of: a force that comes out is the scaled one."""
    path, campaign = lab("csv")
    factor, slower = 10.0**scale, 10.0**stretch
    cells = (line.split(",") for line in recording()[0])
    path.write_text(text(f"{float(t) * slower!r},{float(f) * factor + offset!r}" for t, f in cells))
    ((result,),) = extract_recording(campaign, list(campaign.trials))
    if str(result.breakaway.status) == "ok":
        # A level below zero is none of a rope's, and is taken off and said.
        below = offset < 0.0 and "less than nothing: taken off" in " ".join(result.breakaway.notes)
        wanted_N = TRUE_N * factor + (0.0 if below else offset)
        assert result.peak_N == pytest.approx(wanted_N, abs=2.0 * factor)


test_any_scale, test_any_scale_long = fuzzed(check_any_scale, short=15, share=0.005,
    scale=st.floats(-300, 300), offset=st.floats(-1e6, 1e6), stretch=st.floats(-12, 12))  # fmt: skip


def test_hostile_words_for_options():
    scene = load_scene(ROOT / "data" / "scenes" / "many-turns.toml")
    rng = random.Random("hostile")
    for word in HOSTILE:
        said = rng.choice(["", "1", "1 ", "-1e3"]) + word + rng.choice(["", " mm", " N", "!"])
        unit = rng.choice(["m", "N", "rad", ""])
        for read, *given in ((parse_quantity, said, unit), (parse_any_quantity, said),
                (unit_factor, said, unit), (split_unit_suffix, said),
                (read_levels, f"{said} .. {said}", unit, "--x"), (read_levels, said, unit, "--x"),
                (parse_axis, scene, f"wheel.wrap={said}"),
                (parse_axis, scene, f"wheel.wrap=1deg:{said}:{said}"),
                (lambda one: parse_assignments([one, f"a={one}"], option="--x"), said)):  # fmt: skip
            try:
                with limit():
                    answered(lambda read=read, given=given: read(*given))
            except Exception as error:
                if type(error).__name__ != "BadParameter":  # typer's way to refuse an option
                    raise


if __name__ == "__main__":
    print(faults(map(int, sys.argv[1:])))  # noqa: T201

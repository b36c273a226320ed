"""Numbers that no machine has and counts that no machine can work off: refused at once, with place and limit."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
FIT = ROOT / "fits" / "prth-coupled.json"
HOIST = ROOT / "data" / "scenes" / "hoist.toml"
PULL = ("--wheel-radius", "40 mm", "--wrap", "540 deg", "--end-tension", "80 N")
RIG = ("--wheels", "15 mm .. 60 mm", "--wraps", "90 deg .. 1080 deg", "--end-tensions", "5 N, 80 N",
       "--max-force", "800 N")  # fmt: skip
BILLION = 10**9
MANY = ", ".join(f"{i} {{0}}" for i in range(1, 42))

COMMANDS = {
    "length": (("predict", "--fit", FIT, *PULL, "--wheel-radius", "1e300 mm"), 2, "1e+30 m is the limit"),
    "speed": (("predict", "--fit", FIT, *PULL, "--speed", "1e300 m/s"), 2, "1e+30 m/s is the limit"),
    "no number": (("predict", "--fit", FIT, *PULL, "--wrap", "5e-324 deg"), 2, "1e-30 rad is the limit"),
    "unit": (("predict", "--fit", FIT, *PULL, "--wrap", "1 " + "a" * 30 + "!"), 2, "is not a unit"),
    "power": (("predict", "--fit", FIT, *PULL, "--wrap", "10**10**10 deg"), 2, "is not a unit"),
    "draws": (("budget", "--fit", FIT, *PULL, "--draws", BILLION), 3, "at most 10000000"),
    "repeats": (("simulate", "SIM", "--repeats", BILLION), 3, "the limit is 100000"),
    "all settings": (("plan-tests", "--fit", FIT, *PULL, *RIG, "--wheels", MANY.format("mm"),
                      "--wraps", MANY.format("deg"), "--end-tensions", MANY.format("N")), 3, "the limit is 50000"),
    "conditions": (("plan-tests", "--fit", FIT, *PULL, *RIG, "--conditions", BILLION), 3, "the limit is 1000"),
    "pulls": (("plan-tests", "--fit", FIT, *PULL, *RIG, "--repeats", BILLION), 3, "the limit is 1000"),
    "sweep": (("solve", HOIST, "--sweep", "wheel.wrap=90deg:1440deg:500000",
               "--sweep", "load.end_tension=1N:2N:500000"), 3, "250000000000 points; the limit is 1000000"),
    "axis": (("solve", HOIST, "--sweep", f"wheel.wrap=1deg:2deg:{10**30}"), 3, "from 2 to 1000000"),
    "sweep to": (("solve", HOIST, "--sweep", "load.end_tension=1N:1e300N:5"), 3, "1e+30 N is the limit"),
    "unit of a sweep": (("solve", HOIST, "--sweep", f"wheel.wrap=1{'a' * 40}!:2:3"), 3, "is not a unit"),
}  # fmt: skip


def test_refused_with_place_and_limit(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, (argv, code, words) in COMMANDS.items():
        done = call(*argv)
        assert done.code == code, (name, done.err)
        assert words in done.err, name
        assert not list(tmp_path.iterdir()), name


SCENES = {
    "coefficient": ("press-start-up", "mu = 0.6", "mu = 1e-300", "1e-30 to 1e+30 are the limits"),
    "least coefficient": ("press-start-up", "mu = 0.6", "mu = 1e-29", "from no friction at all"),
    "least wrap": ("press-start-up", '"28.1 deg"', '"1e-12 deg"', "from no friction at all"),
    "damping": ("press-start-up", '"500 N*s/m"', '"9.9e29 N*s/m"', "no grid is fine enough"),
    "points": ("press-start-up", "points = 1601", "points = 100000000", "from 2 to 200000"),
    "blade": ("band-saw", '"1.6 m"', '"1e300 m"', "1e+30 m is the limit"),
    "rate": ("band-saw", "[excitation]", '[excitation]\nfrequencies = ["1e300 Hz"]', "1e+30 Hz is the limit"),
    "factor": ("belt-press", "closure", "load_factor = 1e300\nclosure", "1e-30 to 1e+30 are the limits"),
    "unit": ("belt-press", '"200 mm"', '"200 10**10**10"', "is not a unit"),
    "letters": ("belt-press", '"200 mm"', '"9.8 Millimeterdurchmesserlautdatenblatt-2019"', "is not a unit"),
}  # fmt: skip


def refused(call, tmp_path, name):
    scene, old, new, words = SCENES[name]
    text = (ROOT / "data" / "scenes" / f"{scene}.toml").read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new, 1).replace("../../fits", (ROOT / "fits").as_posix())
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    done = call("solve", tmp_path / "scene.toml")
    assert done.code == 3, (name, done.err)
    assert words in done.err, name
    assert "scene.toml:" in done.err


def test_scenes_that_cannot_be_are_refused(call, tmp_path):
    for name in SCENES:
        refused(call, tmp_path, name)

"""`inspect`: what is in a file, told so that a stranger to it can write the profile."""

import tomllib

import pytest

GERMAN = "Zeit (ms);Kraft (kN)\n" + "".join(f"{10 * i};{i // 10},{i % 10}\n" for i in range(30))


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "pull.csv"
    path.write_text(GERMAN, encoding="utf-8")
    return path


def test_people_and_programs_see_columns_units_ranges_and_the_profile(call, recording):
    done = call("inspect", recording)
    assert done.code == 0
    for fact in ("30 rows", "separator semicolon", "decimal comma", "100 Hz", "Kraft", "kN", "290", "2.9"):
        assert fact in done.out
    assert "[import]" in done.out
    assert done.err == ""
    found = call("inspect", recording, "--json").json()
    assert (found["decimal"], tomllib.loads(found["profile_toml"])["import"]["decimal"]) == (",", ",")


def test_of_a_wide_table_the_first_columns_are_shown(call, tmp_path):
    path = tmp_path / "many.csv"
    header = ",".join(f"channel_{i}" for i in range(30))
    path.write_text("\n".join([header, *[",".join(["123456.789012"] * 30)] * 9]) + "\n", encoding="utf-8")
    lines = call("inspect", path).out.splitlines()
    shown = [line for line in lines if line.startswith("123456.789012")]
    assert len(shown) == 5
    assert all(len(line) <= 200 for line in shown)
    assert "(17 more columns)" in lines


def test_a_text_is_read_whatever_its_ending(call, recording, tmp_path):
    odd = recording.rename(tmp_path / "pull.log")
    assert "read 1 recording" in call("inspect", odd).out
    assert call("inspect", odd, "--format", "delimited").code == 0
    assert "did you mean 'delimited'?" in call("inspect", odd, "--format", "delimted").err


def test_what_is_no_recording_is_refused_with_3(call, bench, tmp_path):
    for content in (b"", b"\x00\x01\x02\xff" * 50):
        path = tmp_path / "odd.csv"
        path.write_bytes(content)
        done = call("inspect", path)
        assert (done.code, done.out) == (3, "")
        assert "odd.csv" in done.err
    for path, told in (
        (tmp_path / "nope", "there is no such file"),
        (bench, "this is a folder"),
        (bench, "ropefric check"),
    ):
        assert told in call("inspect", path).err


def test_the_only_column_in_newtons_is_suggested_as_the_force_and_of_two_none(call, tmp_path):
    path = tmp_path / "zug.csv"
    rows = "".join(f"{10 * i};{i};{i},5\n" for i in range(9))
    path.write_text("Zeit (ms);Weg [mm];Kraft [N]\n" + rows, encoding="utf-8")
    done = call("inspect", path)
    assert 'force = "Kraft [N]"' in done.out
    assert "column 3 is taken as the force because it alone is in N" in " ".join(done.out.split())
    # The suggestion reads the file as it stands.
    profile = tmp_path / "import.toml"
    assert call("inspect", path, "--write-profile", profile).code == 0
    assert tomllib.loads(profile.read_text(encoding="utf-8"))["import"]["channels"]["force"] == "Kraft [N]"
    # Of two such columns none is suggested.
    path.write_text("Zeit (ms);oben [N];unten [kN]\n" + "".join(f"{i};{i};{i}\n" for i in range(9)),
        encoding="utf-8")  # fmt: skip
    done = call("inspect", path)
    assert "force =" not in done.out
    assert "which column is the force" in done.out


def test_real_recordings_of_every_layout(call, real_data):
    wide = call("inspect", real_data / "mecmesin_wide" / "example_forces_big.csv")
    assert "10 recordings side by side" in wide.out
    ragged = call("inspect", next((real_data / "rock_direct_shear").glob("TM11*")))
    assert "please check" in ragged.out

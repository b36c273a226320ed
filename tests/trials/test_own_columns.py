"""Columns of the user's own travel with the trials; near misses of known names and idle channels are said."""

import csv

from ropefric.trials.campaign import check_campaign
from ropefric.trials.result import write_tables
from ropefric.trials.table import read_trial_table, table_of_extraction

OWN = {"note": "rope jumped; later", "weather": "wet, 8 °C", "operator": "A"}


def written(extraction, folder):
    write_tables(extraction, folder)
    with (folder / "trials.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def with_columns(lab, pull_csv, **cells):
    for i in range(2):
        (lab.folder / f"p{i}.csv").write_text(pull_csv(100.0 + i, seed=i), encoding="utf-8")
    return lab.write([lab.row(f"p{i}.csv", **cells) for i in range(2)])


def test_the_note_and_own_columns_reach_the_trial_table(lab, pull_csv, tmp_path):
    quoted = {name: f'"{cell}"' for name, cell in OWN.items()}
    with_columns(lab, pull_csv, **quoted)
    assert check_campaign(lab.path) == lab.load().warnings
    assert not [p for p in check_campaign(lab.path) if p.code == "RF120"]
    extraction = lab.extract()
    rows = written(extraction, tmp_path / "out")
    assert all({name: row[name] for name in OWN} == OWN for row in rows)
    assert extraction.to_dict()["trials"][0]["weather"] == OWN["weather"]
    assert extraction.to_dict()["trials"][0]["note"] == OWN["note"]
    assert read_trial_table(tmp_path / "out" / "trials.csv").used.all()


def test_names_that_begin_with_a_hash_are_trials_and_comments_stand_above_the_header(lab, pull_csv):
    with_columns(lab, pull_csv)
    table = lab.folder / "trials.csv"
    head, *rows = table.read_text().splitlines()
    named = [f'"#{i}",{row}' if i % 2 else f"#{i},{row}" for i, row in enumerate(rows)]
    table.write_text(
        "\n".join(["# two, remarks", '"# quoted, by a spreadsheet",,', f"trial,{head}", *named, ",,,,,"])
    )
    assert [trial.trial for trial in lab.extract().trials] == ["#0", "#1"]
    table.write_text("\n".join([f"trial,{head}", named[0], "# the second day", *named[1:]]))
    (torn,) = (one for one in check_campaign(lab.path) if one.code == "RF103")
    assert (torn.severity, torn.line, "above the header" in torn.fix) == ("error", 3, True)
    table.write_text("\n".join([head, f"#{rows[0]}", *rows[1:]]))  # a row as any other
    (missing,) = (one for one in check_campaign(lab.path) if one.severity == "error")
    assert ("#p0.csv is not there" in missing.message, "above the header" in missing.fix) == (True, True)


def test_every_column_of_the_list_reaches_the_tables_and_what_is_fitted(lab, pull_csv, tmp_path):
    cells = {"from_s": 0.01, "until_s": 2.4, "rope_id": "R1", "wheel": "A", "operator": "Ann", "end_cell": ""}
    with_columns(lab, pull_csv, **cells)
    text = lab.path.read_text() + '[wheels.A]\nradius = "40 mm"\n[wheels.B]\nradius = "40 mm"\n'
    lab.path.write_text(text.replace("[rejection]", ""))
    table = lab.folder / "trials.csv"
    table.write_text(
        table.read_text().replace("p1.csv,40,180,20,0.01,2.4,R1,A", "p1.csv,40,180,20,0.01,2.4,R1,B")
    )
    extraction = lab.extract()
    rows = written(extraction, tmp_path / "out")
    assert [row["wheel"] for row in rows] == ["A", "B"]
    assert {(row["from_s"], row["until_s"], row["operator"]) for row in rows} == {("0.01", "2.4", "Ann")}
    with (tmp_path / "out" / "conditions.csv").open(encoding="utf-8", newline="") as stream:
        assert [row["wheel"] for row in csv.DictReader(stream)] == ["A; B"]
    for found in (read_trial_table(tmp_path / "out" / "trials.csv"), table_of_extraction(extraction)):
        assert found.labels["wheel"] == ("A", "B")


def test_a_near_miss_beside_the_known_column_is_a_warning(lab, pull_csv, tmp_path):
    with_columns(lab, pull_csv, wrap_angel_deg=170, wheel_radus_mm=41)
    told = {p.key: p for p in check_campaign(lab.path) if p.code == "RF120"}
    assert {p.severity for p in told.values()} == {"warning"}
    assert "did you mean 'wrap_angle_deg'" in told["wrap_angel_deg"].fix
    assert "did you mean 'wheel_radius_mm'" in told["wheel_radus_mm"].fix
    rows = written(lab.extract(), tmp_path / "out")
    assert {row["wheel_radius_m"] for row in rows} == {"0.04"}
    assert {row["wrap_angel_deg"] for row in rows} == {"170"}


def test_an_own_column_that_a_fit_would_read_gets_another_name(lab, pull_csv, tmp_path):
    with_columns(lab, pull_csv, breakaway_force_N=1, rope_diameter_std_mm=9, status="fine", peak_N=2)
    rows = written(lab.extract(), tmp_path / "out")
    assert {row["given_breakaway_force_N"] for row in rows} == {"1"}
    assert {(row["status"], row["given_status"]) for row in rows} == {("ok", "fine")}
    table = read_trial_table(tmp_path / "out" / "trials.csv")
    assert table.peak_N.min() > 90
    assert table.rope_radius_std_m.max() < 1e-3


def test_a_trial_table_keeps_what_it_does_not_know_and_doubts_near_misses(tmp_path):
    path = tmp_path / "pulls.csv"
    head = "wheel_radius_mm,rope_diameter_mm,wrap_angle_deg,end_tension_N,peak_N,weather"
    rows = "40,10,180,20,60,wet\n40,10,360,20,90,dry\n"
    path.write_text(f"{head}\n{rows}")
    assert read_trial_table(path).warnings == ()
    path.write_text(f"{head},peak_sdt_N\n" + rows.replace("t\n", "t,1\n").replace("y\n", "y,1\n"))
    (warning,) = read_trial_table(path).warnings
    assert (warning.severity, warning.key) == ("warning", "peak_sdt_N")
    assert "did you mean 'peak_std_N'" in warning.fix

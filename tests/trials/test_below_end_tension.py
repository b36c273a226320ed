"""A break-away force below its end tension: by scatter it stays in the table, by mistake the table is refused."""

import numpy as np
import pytest

from ropefric.errors import DataError
from ropefric.fitting.fit import fit_law
from ropefric.trials.table import read_trial_table

HEAD = "trial,wheel_radius_mm,rope_diameter_mm,wrap_angle_deg,end_tension_N,peak_N"


def read(path, forces_N, wrap_deg=10):
    rows = [f"t{i},40,9.8,{wrap_deg},100,{force_N:.6g}" for i, force_N in enumerate(forces_N)]
    rows += [f"u{i},40,9.8,360,100,{force_N}" for i, force_N in enumerate((140, 144))]
    path.write_text("\n".join([HEAD, *rows, ""]), encoding="utf-8")
    return read_trial_table(path)


def test_scatter_is_kept_with_a_warning_and_the_coefficient_is_not_shifted(tmp_path):
    table = read(tmp_path / "t.csv", [101.5, 100.4, 99.2, 101.1, 102.0])
    assert table.used.all()
    (warning,) = (problem for problem in table.warnings if problem.code == "RF411")
    assert (warning.severity, warning.line, warning.key) == ("warning", 4, "peak_N")
    rise = np.log(table.peak_N / 100)
    mu = table.wrap_angle_rad @ rise / (table.wrap_angle_rad @ table.wrap_angle_rad)
    assert fit_law(table, "constant")["mu"].value == pytest.approx(
        mu, rel=0.01
    )  # five pulls and two weigh differently


@pytest.mark.parametrize(
    "forces_N", [[101.5, 60.0, 101.1], [99.0, 98.0, 97.0, 98.5, 99.5], [101.0, 0.0, 102.0]]
)
def test_what_is_no_scatter_is_refused(tmp_path, forces_N):
    with pytest.raises(DataError):
        read(tmp_path / "t.csv", forces_N)

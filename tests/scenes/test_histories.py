"""The histories of a start-up as a table are the start-up's own arrays, each under its roller or span."""

import numpy as np

from ropefric.scenes.kinds import KINDS
from ropefric.scenes.scene import load_scene
from ropefric.scenes.solve import solve_scene


def test_every_history_stands_under_its_name(scenes_folder):
    short = {"start_up.duration": "0.1 s", "start_up.simulate": "0.2 s", "start_up.points": 21}
    answer = solve_scene(load_scene(scenes_folder / "press-start-up.toml", short)).answer
    columns, found = KINDS["press"].histories["start_up.csv"](answer), answer.start_up
    assert {column.shape for column in columns.values()} == {found.time_s.shape}
    spans = [span.name for span in found.press.spans]
    assert np.array_equal(columns["tension_N.8"], found.tension_N[:, spans.index("8")])
    rollers = [roller.name for roller in found.press.rollers]
    assert np.array_equal(columns["utilisation.2"], found.utilisation[:, rollers.index("2")])
    assert np.array_equal(columns["as_printed.2"], found.as_printed[:, rollers.index("2")])
    assert np.array_equal(columns["travel_m.13"], found.travel_m[:, 1])
    assert len(columns) == 2 + 14 + 2 + 8 * 13

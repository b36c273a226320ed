"""Words and failures: errors that say where and how, registries that know what was meant, a glossary without gaps."""

import pickle
from types import SimpleNamespace

import pytest

from ropefric.errors import (
    DataError,
    FitError,
    InputError,
    Problem,
    RopefricError,
    SolverError,
    UnknownNameError,
    raise_problems,
)
from ropefric.glossary import GLOSSARY, axis_label
from ropefric.registry import Registry, did_you_mean


def test_every_error_is_ours_and_pythons():
    for ours, pythons in ((InputError, ValueError), (UnknownNameError, LookupError), (DataError, ValueError),
            (FitError, RuntimeError), (SolverError, RuntimeError)):  # fmt: skip
        assert issubclass(ours, RopefricError)
        assert issubclass(ours, pythons)
        assert ours("x").exit_code == 3


def test_an_error_tells_what_where_and_how():
    error = DataError("the wrap angle is empty", code="RF121", path="trials.csv", line=14, key="wrap",
        fix="fill it")  # fmt: skip
    assert str(error) == "trials.csv:14 wrap: the wrap angle is empty Fix: fill it"
    assert error.to_dict() == {"error": {"code": "RF121", "message": "the wrap angle is empty",
        "where": "trials.csv:14 wrap", "fix": "fill it"}}  # fmt: skip


def test_errors_survive_the_way_between_processes():
    problems = (Problem(code="RF1", message="a"), Problem(code="RF2", message="b", line=3, path="x"))
    error = DataError("a", code="RF1", path="x.csv", line=2, key="k", fix="f", problems=problems)
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301  (our own bytes)
    assert type(copy) is DataError
    assert (str(copy), copy.problems) == (str(error), problems)
    assert str(error) == "x.csv:2 k: a Fix: f (the first of 2, see .problems)"
    assert len(copy.to_dict()["error"]["problems"]) == 2


def test_only_errors_are_raised_and_all_of_them():
    raise_problems([Problem(code="RF310", message="few repeats", severity="warning")])
    with pytest.raises(DataError) as caught:
        raise_problems([Problem(code="RF310", message="few repeats", severity="warning"),
            Problem(code="RF101", message="no file", path="a"),
            Problem(code="RF102", message="no number", path="b")])  # fmt: skip
    assert [problem.code for problem in caught.value.problems] == ["RF101", "RF102"]
    assert caught.value.code == "RF101"


def test_a_problem_prints_as_people_read_it():
    problem = Problem(code="RF310", message="n = 5", path="t.csv", line=3, fix="repeat", severity="warning")
    assert str(problem) == "warning RF310 t.csv:3  n = 5\n  fix: repeat"


def test_a_registry_is_ordered_read_only_and_helpful():
    members = [SimpleNamespace(name=name) for name in ("wrap-power", "constant")]
    registry = Registry("law", members)
    assert list(registry) == ["wrap-power", "constant"]
    assert registry["constant"] is members[1]
    assert "constant" in registry
    assert (len(registry), registry.get("constnat", "none")) == (2, "none")
    assert registry.get("constant") is members[1]
    with pytest.raises(UnknownNameError, match="unknown law 'constnat' Fix: did you mean 'constant'"):
        registry["constnat"]
    with pytest.raises(ValueError, match="two members of the law registry are called"):
        Registry("law", [members[0], members[0]])
    with pytest.raises(TypeError):
        registry["x"] = members[0]


def test_nothing_close_lists_what_is_known():
    assert did_you_mean("q", ["b", "a"]) == "known: a, b"
    assert did_you_mean("CONSTANT", ["constant"]) == "did you mean 'constant'?"
    assert did_you_mean("x", []) == "none is known"


def test_the_glossary_names_units_as_its_names_do():
    endings = {"_m": "m", "_N": "N", "_s": "s", "_rad": "rad", "_V": "V", "_Hz": "Hz", "_kg_m": "kg/m"}
    endings |= {"_N_m": "N/m", "_N_s": "N/s", "_m_s": "m/s"}
    for name, term in GLOSSARY.items():
        ending = max((e for e in endings if name.endswith(e)), key=len, default="")
        if ending:
            assert term.unit == ("N m" if name.endswith("torque_N_m") else endings[ending]), name
        assert term.meaning[0].isupper()
        assert axis_label(name).startswith(term.meaning.split(";")[0])

"""`ropefric diagnose`: why a rope does not obey the capstan equation."""

from ropefric.cli.options import Answer, Command, TableArgument, exit_code_of, read_table
from ropefric.cli.output import Output


def diagnose(out: Output, trials: TableArgument) -> Answer:
    """Say why trials do not obey the capstan equation, with the evidence: offset, load, size, wrap, no gross slip.

    Exits with 4 unless the best law is supported: when the data leave two laws undecided, or no choice at all.
    """
    from ropefric.fitting.diagnose import diagnose as find_causes  # noqa: PLC0415  (quick start-up)
    from ropefric.report.parts import diagnosis_section  # noqa: PLC0415

    found = find_causes(read_table(trials, out))
    return Answer(found.to_dict(), [diagnosis_section(found, full=True)], exit_code_of(found.verdict))


COMMAND = Command("diagnose", diagnose, "ropefric diagnose fits/prth-trials.csv", order=110)

"""`ropefric compare`: which friction law the data ask for."""

from typer import Option

from ropefric.cli.options import Answer, Command, TableArgument, exit_code_of, read_table
from ropefric.cli.output import Output, Progress


def compare(
    out: Output,
    trials: TableArgument,
    *,
    laws: list[str] | None = Option(
        None, metavar="NAME[,NAME…]", help="Laws to compare, all by default; repeatable."
    ),
) -> Answer:
    """Rank friction laws on a trial table by AICc, with weights and the error at unseen conditions.

    The two constant laws always stand in the comparison. Exits with 4 unless the best law is supported: when the
    data leave two laws undecided, or no choice at all.
    """
    from ropefric.fitting.choice import choose_law  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.fitting.compare import compare_laws  # noqa: PLC0415
    from ropefric.report.parts import comparison_section, verdict_section  # noqa: PLC0415

    names = [name.strip() for text in laws or () for name in text.split(",") if name.strip()]
    table = read_table(trials, out)
    with Progress(out, "fit") as progress:
        found = compare_laws(
            table, names or None, progress=lambda law, done, total: progress.update(done, total, law)
        )
    choice = choose_law(found)
    verdict = verdict_section(choice.verdict, f"The law: {choice.fit.law}")
    return Answer(
        found.to_dict() | choice.to_dict(),
        [comparison_section(found), verdict],
        exit_code_of(choice.verdict),
    )


COMMAND = Command("compare", compare, "ropefric compare fits/prth-trials.csv", order=100)

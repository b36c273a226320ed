"""A campaign's result in a page of text."""

from ropefric.glossary import counted
from ropefric.pipeline.run import CampaignRun
from ropefric.report.parts import (
    comparison_section,
    diagnosis_section,
    fit_section,
    prediction_section,
    verdict_section,
)
from ropefric.report.section import Section, as_text
from ropefric.trials.result import count_trials, outcome_words


def summary_sections(run: CampaignRun) -> tuple[Section, ...]:
    """Return the law that is used, how it won, what is doubtful, and the lift force of the design."""
    answer = run.answer
    sections = [
        _campaign(run),
        verdict_section(answer.verdict, "The verdict"),
        fit_section(answer.fit, f"The law: {answer.fit.law}, {answer.winner.how}"),
        comparison_section(answer.comparison),
        diagnosis_section(answer.diagnosis),
        Section(title="Doubts", notes=answer.doubts or ("nothing was found",)),
    ]
    if answer.prediction is not None:
        sections.append(prediction_section(answer.prediction))
    elif run.campaign.design is None:
        sections.append(
            Section(title="Lift force", lines=("the campaign names no wheel: add [design] to it",))
        )
    return tuple(sections)


def summary_text(run: CampaignRun) -> str:
    """Return the summary as plain text."""
    return as_text(summary_sections(run))


def _campaign(run: CampaignRun) -> Section:
    counts = count_trials(run.extraction)
    statuses = ", ".join(f"{n} {status}" for status, n in counts["status"].items() if status != "ok")
    line = (
        f"{run.campaign.name}: {counted(counts['n_trials'], 'trial')} of "
        f"{counted(counts['n_conditions'], 'condition')}: {outcome_words(counts)}"
    )
    lines = [line]
    if counts["n_rejected"]:
        lines.append(f"rejected by the rule {run.campaign.rejection}; look for a physical reason")
    if statuses:
        lines.append(f"recordings without a usable force: {statuses}")
    lines += [
        f"force cell {name}: {', '.join(cell.assumed)} assumed, not stated: state them in [cells.{name}]"
        for name, cell in run.campaign.cells.items()
        if cell.assumed
    ]
    return Section(title="", lines=tuple(lines))

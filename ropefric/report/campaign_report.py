"""A campaign's report: what to know first, the result, the evidence, settings and provenance."""

from ropefric import __version__
from ropefric.glossary import counted
from ropefric.pipeline.evidence import Evidence
from ropefric.pipeline.provenance import Provenance
from ropefric.pipeline.run import CampaignRun
from ropefric.report.alerts import alerts_of
from ropefric.report.chapter import Alert, Block, Chapter, Fold, Report
from ropefric.report.key_facts import key_facts, measured_section
from ropefric.report.lab_plan import plan_sections
from ropefric.report.origin import provenance_blocks
from ropefric.report.parts import (
    comparison_section,
    diagnosis_section,
    fit_section,
    notes_sections,
    origin_section,
)
from ropefric.report.pictures import Pictures
from ropefric.report.section import Section
from ropefric.report.trial_tables import conditions_section, set_aside_section
from ropefric.report.uncertainty import uncertainty_sections
from ropefric.trials.result import count_trials, outcome_words

_WHERE = (
    "Chosen among the wheels that were used, and wraps and end tensions between the smallest and the largest that "
    "were, so that the lift force of the design becomes as certain as it can."
)
_NO_FIGURES = "This report was made without figures; `ropefric report` adds them."


def campaign_report(
    run: CampaignRun, evidence: Evidence, provenance: Provenance, pictures: Pictures
) -> Report:
    """Return a campaign's report."""
    counts = count_trials(run.extraction)
    lead = (
        f"{counted(counts['n_trials'], 'trial')} of {counted(counts['n_conditions'], 'condition')}: "
        f"{outcome_words(counts)}; "
        "the friction law they ask for, how good it is, and the lift force it gives."
    )
    chapters = (
        Chapter(key="warnings", title="What to know first", blocks=(_alerts(run, evidence, pictures),)),
        Chapter(key="result", title="The result", blocks=_result(run, evidence)),
        Chapter(key="trials", title="What was measured", blocks=_trials(run, evidence, pictures)),
        Chapter(key="friction", title="Does it obey the capstan equation?", blocks=_friction(run, pictures)),
        Chapter(key="law", title="How good the law is", blocks=_law(run, pictures)),
        Chapter(
            key="uncertainty", title="What makes up the uncertainty", blocks=_uncertainty(evidence, pictures)
        ),
        Chapter(key="design", title="The design and its neighbours", blocks=pictures.get("design", ())),
        Chapter(key="next", title="What to measure next", blocks=_next(evidence)),
        Chapter(key="provenance", title="Settings and provenance", blocks=provenance_blocks(provenance)),
    )
    return Report(
        title=run.campaign.name,
        lead=lead,
        made_by=f"ropefric {__version__}",
        chapters=tuple(chapter for chapter in chapters if chapter.blocks),
    )


def _alerts(run: CampaignRun, evidence: Evidence, pictures: Pictures) -> tuple[Alert, ...]:
    found = alerts_of(run, evidence)
    if not found:
        found = (Alert(grade="note", title="Nothing was found", text="No check stands against the result."),)
    return found if pictures else (*found, Alert(grade="note", title="No figures", text=_NO_FIGURES))


def _result(run: CampaignRun, evidence: Evidence) -> tuple[Block, ...]:
    answer = run.answer
    blocks: list[Block] = [key_facts(run, evidence)]
    blocks.append(fit_section(answer.fit, f"The law: {answer.fit.law}, {answer.winner.how}"))
    if evidence.hand:
        sheet = Section(title="", lines=evidence.hand, verbatim=True)
        blocks.append(Fold(title="The lift force by hand", sections=(sheet,)))
    return tuple(blocks)


def _trials(run: CampaignRun, evidence: Evidence, pictures: Pictures) -> tuple[Block, ...]:
    drawn = pictures.get("trials", ())
    return (
        measured_section(run),
        *drawn[:1],
        set_aside_section(run.extraction),
        conditions_section(run.extraction, evidence),
        *drawn[1:],
    )


def _friction(run: CampaignRun, pictures: Pictures) -> tuple[Block, ...]:
    section = diagnosis_section(run.answer.diagnosis)
    untitled = Section(title="", lines=section.lines, notes=section.notes)
    tests = tuple(
        f"{cause.cause}: {cause.experiment}"
        for cause in run.answer.diagnosis.causes
        if cause.supported == "cannot-tell"
    )
    undecided = (Section(title="What would decide it", notes=tests),) if tests else ()
    return (untitled, *pictures.get("friction", ()), *undecided)


def _law(run: CampaignRun, pictures: Pictures) -> tuple[Block, ...]:
    answer = run.answer
    tested = origin_section(answer.fit).notes
    return (
        comparison_section(answer.comparison),
        *pictures.get("ladder", ()),
        *pictures.get("bands", ()),
        Section(title="Tested range: beyond it the law is extrapolated", notes=tested),
        *pictures.get("residuals", ()),
        *notes_sections(answer.fit),
    )


def _uncertainty(evidence: Evidence, pictures: Pictures) -> tuple[Block, ...]:
    typical = f"Budget of the {{name}} of condition {evidence.typical_number}, a typical one"
    blocks: list[Block] = []
    for stated, key, title, more in (
        (evidence.lift, "budget_lift", "Budget of the {name} of the design", pictures.get("tornado", ())),
        (evidence.typical, "budget_force", typical, ()),
    ):
        if stated is not None:
            budget, *rest = uncertainty_sections(stated, title.format(name=stated.model.name))
            told = (part for part in rest if part.lines or part.notes)
            blocks += [budget, *pictures.get(key, ()), *told, *more]
    return tuple(blocks)


def _next(evidence: Evidence) -> tuple[Block, ...]:
    if evidence.plan is None:
        return ()
    return Section(title="", lines=(_WHERE,)), *plan_sections(evidence.plan)

"""A plan of tests as sections: what to test, and what it is expected to be worth."""

import math

import numpy as np

from ropefric.fitting.next_tests import LabPlan, Outlook
from ropefric.glossary import counted
from ropefric.report.section import Section, Table, interval, plain

_GOALS = {"v": "the wanted prediction", "d": "the parameters"}


def plan_sections(plan: LabPlan) -> tuple[Section, ...]:
    """Return a plan as sections: its conditions, and the wanted predictions before and after."""
    n = len(plan)
    rows = tuple(
        (
            str(row["condition"]),
            plain(1e3 * row["wheel_radius_m"]),
            plain(math.degrees(row["wrap_angle_rad"])),
            plain(row["end_tension_N"]),
            str(row["repeats"]),
            plain(row["expected_lift_force_N"]),
            f"{100 * row['cell_use']:.0f} %",
        )
        for row in plan.rows()
    )
    headings = ("no.", "R_w [mm]", "wrap [deg]", "F_B [N]", "repeats", "expected F_A [N]", "of the cell")
    pulls = counted(n * plan.repeats, "pull")
    title = f"{counted(n, 'condition')} to test, {pulls}, the best for {_GOALS[plan.criterion]}"
    scatter = plan.planned.scatter
    values = plan.planned.law.as_mapping(plan.planned.theta)
    expected = ", ".join(
        f"{name} = {plain(values[name], '.3g')} ± {plain(std, '.1g')}"
        for name, std in plan.expected_parameter_std().items()
    )
    means = (
        f"{plan.planned.law.name}; scatter between repeats "
        f"{100 * scatter.within:.2g} %, between conditions {100 * scatter.between:.2g} %, measuring chain "
        f"{plain(scatter.instrument_N, '.2g')} N"
    )
    search = (
        f"the best of {plan.n_candidates} possible conditions; {plan.agreeing_starts} of {plan.starts} starts of "
        "the search came out as good"
    )
    what = Section(
        title=title,
        lines=(means, f"standard errors to expect: {expected}", search),
        table=Table(headings=headings, rows=rows),
        notes=plan.notes,
    )
    return what, *(_worth(plan, i) for i in range(len(plan.wanted)))


def _worth(plan: LabPlan, i: int) -> Section:
    at, lift_N = plan.wanted, float(np.exp(plan.wanted_log_lift[i]))
    where = (
        f"R_w = {plain(1e3 * at.wheel_radius_m[i])} mm, wrap {plain(math.degrees(at.wrap_angle_rad[i]))} deg, "
        f"F_B = {plain(at.end_tension_N[i])} N"
    )
    cases = (
        ("before", plan.before),
        ("with this plan", plan.after),
        ("one factor at a time about the middle", plan.one_factor),
        ("one factor at a time about the wanted condition", plan.one_factor_at_target),
    )
    rows = tuple(_case(name, outlook, lift_N, i) for name, outlook in cases)
    headings = ("tests", "standard error [N]", f"{100 * plan.level:g} % interval of the mean [N]", "dof")
    gain = (
        f"intervals {plain(plan.gain, '.3g')} times as narrow as one factor at a time about the middle, "
        f"{plain(plan.gain_at_target, '.3g')} times as about the wanted condition"
    )
    caution = "expected for these parameters and this scatter; plan again when the first tests have told them better"
    return Section(
        title=f"Worth of the plan: F_A = {plain(lift_N)} N",
        lines=(where,),
        table=Table(headings=headings, rows=rows),
        notes=(gain, caution),
    )


def _case(name: str, outlook: Outlook, lift_N: float, i: int) -> tuple[str, ...]:
    half = float(outlook.half_width_log[i])
    span = interval((lift_N * math.exp(-half), lift_N * math.exp(half))) if half < 50.0 else "cannot be told"
    return name, plain(lift_N * float(outlook.std_log[i]), ".2g"), span, str(outlook.dof)

"""The field's words: every quantity's name, symbol, unit and meaning, for axes, headers and help."""

from dataclasses import dataclass

from ropefric.errors import UnknownNameError
from ropefric.registry import Registry


@dataclass(frozen=True, slots=True)
class Term:
    """One quantity of the field."""

    name: str
    symbol: str
    unit: str
    meaning: str


GLOSSARY: Registry[Term] = Registry(
    "term",
    [
        Term("trial", "", "", "Trial; the name of one measurement"),
        Term("file", "", "", "File the recording came from"),
        Term("sample", "", "", "Block of a file that holds several recordings"),
        Term("status", "", "", "Status; what became of the recording"),
        Term("kept", "", "", "Kept; false where the rejection rule or the user set the trial aside"),
        Term("time_s", "t", "s", "Time"),
        Term("force_N", "F", "N", "Force"),
        Term("counts", "", "count", "ADC counts"),
        Term("voltage_V", "U", "V", "Voltage"),
        Term("wheel_radius_m", "R_w", "m", "Wheel radius"),
        Term("rope_radius_m", "R_r", "m", "Rope radius"),
        Term("rope_diameter_m", "d", "m", "Rope diameter"),
        Term("size_ratio", "r", "-", "Size ratio R_w/R_r"),
        Term("wrap_angle_rad", "φ", "rad", "Wrap angle"),
        Term("end_tension_N", "F_B", "N", "End tension; slack side"),
        Term("lift_force_N", "F_A", "N", "Lift force; tight side"),
        Term("peak_N", "F_A", "N", "Break-away force; static peak of the smoothed trace"),
        Term("peak_raw_N", "F_A,raw", "N", "Break-away force before smoothing"),
        Term("peak_std_N", "u(F_A)", "N", "Standard uncertainty of the break-away force"),
        Term("peak_time_s", "t_A", "s", "Time of break-away"),
        Term("two_line_N", "F_A,2l", "N", "Break-away force from the two-line fit"),
        Term("kinetic_N", "F_k", "N", "Kinetic force; mean while sliding"),
        Term("plateau_N", "F_h", "N", "Held force; mean of a plateau"),
        Term("bias_N", "", "N", "First-order bias of the smoothed peak; negative reads low"),
        Term("window_s", "w", "s", "Smoothing window"),
        Term("noise_std_N", "σ", "N", "Noise of one sample"),
        Term("loading_rate_N_s", "dF/dt", "N/s", "Loading rate before break-away"),
        Term("dwell_s", "", "s", "Dwell; time under load before the pull"),
        Term("rope_id", "", "", "Rope specimen"),
        Term("cell", "", "", "Force cell"),
        Term("wheel", "", "", "Wheel"),
        Term("n", "n", "-", "Number of trials"),
        Term("n_kept", "n_k", "-", "Number of trials kept"),
        Term("mean_all_N", "", "N", "Mean of all trials"),
        Term("std_all_N", "s", "N", "Sample standard deviation of all trials"),
        Term("mean_kept_N", "", "N", "Mean of the trials kept"),
        Term("std_kept_N", "s", "N", "Sample standard deviation of the trials kept"),
        Term("mu", "μ", "-", "Friction coefficient; local"),
        Term("mu_average", "μ̄", "-", "Friction coefficient; average over the wrap"),
        Term("lift_margin", "", "-", "Lift force over the weight of the payload; above 1 it lifts"),
        Term("margin_N", "", "N", "Lift force beyond the weight of the payload"),
        Term("linear_density_kg_m", "ρ", "kg/m", "Mass per length"),
        Term("speed_m_s", "v", "m/s", "Rope speed"),
        Term("stiffness_N_m", "k", "N/m", "Stiffness"),
        Term("first_frequency_Hz", "f_1", "Hz", "First natural frequency"),
        Term("utilisation", "U", "-", "Friction used; 1 at gross slip"),
        Term("largest_utilisation", "", "-", "Largest share of friction used; 1 at gross slip"),
        Term("tension_N", "T", "N", "Tension"),
        Term("effective_tension_N", "T'", "N", "Effective tension; less what keeps the belt on its path"),
        Term("preload_N", "F", "N", "Preload"),
        Term("mu_required", "", "-", "Friction coefficient at which slip begins"),
        Term("power_W", "P", "W", "Power"),
        Term("full_scale_N", "FS", "N", "Full scale of the force cell"),
        Term("sampling_rate_Hz", "f_s", "Hz", "Sampling rate"),
    ],
)
"""Every quantity by name."""


def axis_label(name: str) -> str:
    """Return an axis label with symbol and unit."""
    term = GLOSSARY[name]
    text = term.meaning.split(";")[0]
    if term.symbol:
        text = f"{text} {term.symbol}"
    return f"{text} [{term.unit}]" if term.unit else text


def describe(name: str) -> str:
    """Return what a name means, or the name itself where the glossary does not know it."""
    try:
        return GLOSSARY[name].meaning
    except UnknownNameError:
        return name


def counted(n: int, noun: str) -> str:
    """Return a number of things in words."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"

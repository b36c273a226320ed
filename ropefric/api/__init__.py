"""The functions of `import ropefric as rf`: what notebooks and scripts need, each a call into its room.

Trials may be given as a trial table, a pandas DataFrame, the path of a CSV file, or the result of `extract`; fits
as results or as paths of their files.
"""

from ropefric.api.fits import compare, diagnose, fit
from ropefric.api.inputs import trial_table
from ropefric.api.recordings import extract, find_breakaway, read_trace, read_trial, reject, smooth
from ropefric.api.wheels import design, predict, run
from ropefric.fitting.store import load_fit, save_fit
from ropefric.trials.campaign import load_campaign

__all__ = [
    "compare",
    "design",
    "diagnose",
    "extract",
    "find_breakaway",
    "fit",
    "load_campaign",
    "load_fit",
    "predict",
    "read_trace",
    "read_trial",
    "reject",
    "run",
    "save_fit",
    "smooth",
    "trial_table",
]

from ropefric.api.fits import compare as compare
from ropefric.api.fits import diagnose as diagnose
from ropefric.api.fits import fit as fit
from ropefric.api.inputs import trial_table as trial_table
from ropefric.api.recordings import extract as extract
from ropefric.api.recordings import find_breakaway as find_breakaway
from ropefric.api.recordings import read_trace as read_trace
from ropefric.api.recordings import read_trial as read_trial
from ropefric.api.recordings import reject as reject
from ropefric.api.recordings import smooth as smooth
from ropefric.api.scenes import explain as explain
from ropefric.api.scenes import solve as solve
from ropefric.api.scenes import sweep as sweep
from ropefric.api.uncertainty import budget as budget
from ropefric.api.uncertainty import measured_budgets as measured_budgets
from ropefric.api.uncertainty import plan_tests as plan_tests
from ropefric.api.wheels import design as design
from ropefric.api.wheels import predict as predict
from ropefric.api.wheels import run as run
from ropefric.fitting.lmfit_model import lmfit_model as lmfit_model
from ropefric.fitting.store import load_fit as load_fit
from ropefric.fitting.store import save_fit as save_fit
from ropefric.scenes.scene import load_scene as load_scene
from ropefric.scenes.scene_templates import write_scenes as write_scenes
from ropefric.trials.campaign import load_campaign as load_campaign

__version__: str

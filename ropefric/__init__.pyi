from ropefric.api.models import budget as budget
from ropefric.api.models import compare as compare
from ropefric.api.models import design as design
from ropefric.api.models import diagnose as diagnose
from ropefric.api.models import explain as explain
from ropefric.api.models import fit as fit
from ropefric.api.models import measured_budgets as measured_budgets
from ropefric.api.models import plan_tests as plan_tests
from ropefric.api.models import predict as predict
from ropefric.api.models import run as run
from ropefric.api.models import solve as solve
from ropefric.api.models import sweep as sweep
from ropefric.api.recordings import extract as extract
from ropefric.api.recordings import find_breakaway as find_breakaway
from ropefric.api.recordings import read_trace as read_trace
from ropefric.api.recordings import read_trial as read_trial
from ropefric.api.recordings import reject as reject
from ropefric.api.recordings import smooth as smooth
from ropefric.api.recordings import trial_table as trial_table
from ropefric.fitting.lmfit_model import lmfit_model as lmfit_model
from ropefric.fitting.store import load_fit as load_fit
from ropefric.fitting.store import save_fit as save_fit
from ropefric.scenes.scene import load_scene as load_scene
from ropefric.scenes.scene_templates import write_scenes as write_scenes
from ropefric.trials.campaign import load_campaign as load_campaign

__version__: str

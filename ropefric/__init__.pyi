from ropefric.api import budget as budget
from ropefric.api import compare as compare
from ropefric.api import design as design
from ropefric.api import diagnose as diagnose
from ropefric.api import explain as explain
from ropefric.api import extract as extract
from ropefric.api import find_breakaway as find_breakaway
from ropefric.api import fit as fit
from ropefric.api import measured_budgets as measured_budgets
from ropefric.api import plan_tests as plan_tests
from ropefric.api import predict as predict
from ropefric.api import read_trace as read_trace
from ropefric.api import read_trial as read_trial
from ropefric.api import reject as reject
from ropefric.api import run as run
from ropefric.api import smooth as smooth
from ropefric.api import solve as solve
from ropefric.api import sweep as sweep
from ropefric.api import trial_table as trial_table
from ropefric.fitting.lmfit_model import lmfit_model as lmfit_model
from ropefric.fitting.store import load_fit as load_fit
from ropefric.fitting.store import save_fit as save_fit
from ropefric.scenes.scene import load_scene as load_scene
from ropefric.scenes.scene_templates import write_scenes as write_scenes
from ropefric.trials.campaign import load_campaign as load_campaign

__version__: str

from ropefric.api import compare as compare
from ropefric.api import design as design
from ropefric.api import diagnose as diagnose
from ropefric.api import extract as extract
from ropefric.api import find_breakaway as find_breakaway
from ropefric.api import fit as fit
from ropefric.api import load_campaign as load_campaign
from ropefric.api import load_fit as load_fit
from ropefric.api import predict as predict
from ropefric.api import read_trace as read_trace
from ropefric.api import read_trial as read_trial
from ropefric.api import reject as reject
from ropefric.api import run as run
from ropefric.api import save_fit as save_fit
from ropefric.api import smooth as smooth
from ropefric.api import trial_table as trial_table

__version__: str

from .entry import main as main
from .program import app as app

from .cards import html_of as html_of
from .frames import frame_of as frame_of
from .plots import plotted as plotted

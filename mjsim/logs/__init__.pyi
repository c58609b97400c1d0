from . import mrclam as mrclam
from . import victoria_park as victoria_park
from .mrclam import import_mrclam as import_mrclam
from .victoria_park import import_victoria_park as import_victoria_park

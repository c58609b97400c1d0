from .files import shipped_name as shipped_name
from .live import LiveView as LiveView
from .studio import Studio as Studio

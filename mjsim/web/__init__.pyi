from .live import LiveView as LiveView
from .shipped import shipped_name as shipped_name
from .studio import Studio as Studio

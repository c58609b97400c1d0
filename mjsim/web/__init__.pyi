from .live import LiveView as LiveView
from .studio import Studio as Studio
from .worlds import shipped_name as shipped_name

from .arithmetic import Value as Value
from .expand import expand as expand
from .expand import needs_expansion as needs_expansion
from .merge import OPEN as OPEN
from .repeats import Repeat as Repeat
from .schema import editor_schema as editor_schema
from .schema import panel_schema as panel_schema
from .schema import world_schema as world_schema

from .budget import XacroBudget as XacroBudget
from .budget import XacroError as XacroError
from .resolve import ROBOT_PARTS as ROBOT_PARTS
from .resolve import Resolved as Resolved
from .resolve import parsed as parsed
from .resolve import resolved as resolved
from .substitution import Given as Given
from .yaml_in import plain_yaml as plain_yaml

from .budget import XacroError as XacroError
from .resolve import parsed as parsed
from .resolve import resolved as resolved
from .substitution import Given as Given

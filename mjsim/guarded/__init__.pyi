from .limits import Allowance as Allowance
from .limits import limits_for as limits_for
from .reader import Reader as Reader
from .reader import guarded as guarded
from .reader import guarded_parts as guarded_parts
from .wire import Plain as Plain

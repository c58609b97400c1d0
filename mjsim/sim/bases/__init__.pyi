from .balancing import balancing_info as balancing_info
from .gear import RunningGear as RunningGear
from .makers import MAKERS as MAKERS
from .makers import gear_of as gear_of

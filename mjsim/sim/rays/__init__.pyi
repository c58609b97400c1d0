from .batch_rays import BatchRays as BatchRays
from .proximity import ProximityRing as ProximityRing
from .rays import HIDDEN as HIDDEN
from .rays import Rays as Rays

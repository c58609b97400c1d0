from .batch_rays import BatchRays as BatchRays
from .proximity import ProximityRing as ProximityRing
from .ray_fan import HIDDEN as HIDDEN
from .ray_fan import Rays as Rays

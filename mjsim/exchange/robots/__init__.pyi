from .bring import BroughtRobot as BroughtRobot
from .bring import bring_robot as bring_robot
from .gear import Wishes as Wishes

from .ahead import Wishes as Wishes
from .bring import BroughtRobot as BroughtRobot
from .bring import bring_robot as bring_robot

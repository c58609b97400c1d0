from .bring import bring_robot as bring_robot
from .brought import BroughtRobot as BroughtRobot
from .brought import RobotOptions as RobotOptions

from .ahead import RobotOptions as RobotOptions
from .bring import BroughtRobot as BroughtRobot
from .bring import bring_robot as bring_robot

from .import_robot import bring_robot as bring_robot
from .robot_import import BroughtRobot as BroughtRobot
from .robot_import import RobotOptions as RobotOptions

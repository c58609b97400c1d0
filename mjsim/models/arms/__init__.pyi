from .arm_checks import ArmFileError as ArmFileError
from .arm_checks import text_place as text_place
from .arm_files import FileArm as FileArm
from .arm_files import FileLink as FileLink
from .arm_files import read_arm as read_arm
from .arm_motors import Motors as Motors

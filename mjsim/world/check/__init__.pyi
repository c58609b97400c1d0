from .leading import led_goals as led_goals
from .leading import led_joints as led_joints
from .leading import led_values as led_values
from .movers import misplaced as misplaced
from .plausibility import check_world as check_world
from .reaching import arm_of_event as arm_of_event
from .standing import Solids as Solids
from .standing import disc as disc

from .movers import misplaced as misplaced
from .plausibility import check_world as check_world
from .standing import Solids as Solids
from .standing import disc as disc

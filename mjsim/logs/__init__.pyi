from .calibration import Calibration as Calibration
from .calibration import calibrate as calibrate
from .calibration import write_noise as write_noise
from .kinds import import_log as import_log
from .log import Wishes as Wishes
from .mrclam import import_mrclam as import_mrclam
from .observed import write_log as write_log
from .victoria_park import import_victoria_park as import_victoria_park

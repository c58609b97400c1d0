from .calibration import Calibration as Calibration
from .calibration import calibrate as calibrate
from .calibration import write_noise as write_noise
from .data_sets import import_mrclam as import_mrclam
from .data_sets import import_victoria_park as import_victoria_park
from .importing import import_log as import_log
from .observed import write_log as write_log
from .wishes import Wishes as Wishes

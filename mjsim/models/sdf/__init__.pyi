from .sdf_frames import SdfFrames as SdfFrames
from .sdf_frames import floats as floats
from .sdf_models import is_robot as is_robot
from .sdf_models import mjcf_of_sdf as mjcf_of_sdf
from .sdf_models import sdf_named_in as sdf_named_in
from .sdf_shapes import mesh_of as mesh_of
from .sdf_shapes import sizes_of as sizes_of

from .carmen_out import export_carmen as export_carmen
from .euroc_out import export_euroc as export_euroc
from .rosbag2 import export_rosbag2 as export_rosbag2
from .tum_rgbd import export_tum_rgbd as export_tum_rgbd

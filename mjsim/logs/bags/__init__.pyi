from .bag_file import Bag as Bag
from .bag_file import is_bag as is_bag
from .bag_file import schemas_of as schemas_of
from .bag_messages import assumed_intrinsics as assumed_intrinsics
from .bag_messages import pose_of as pose_of
from .bag_pictures import shown_depth as shown_depth
from .bag_to_logs import read_bag as read_bag
from .bag_topics import POSES as POSES

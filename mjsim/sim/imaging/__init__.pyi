from .imager import Imager as Imager
from .imager import PlainImager as PlainImager
from .imager import imager_of as imager_of
from .lens import BentView as BentView
from .lens import intrinsics_of as intrinsics_of
from .shutter import Shutter as Shutter
from .stereo import StereoDepth as StereoDepth

from .visual_slam import VisualSlam as VisualSlam

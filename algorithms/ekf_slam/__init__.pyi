from .ekf_slam import EkfSlam as EkfSlam

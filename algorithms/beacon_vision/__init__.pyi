from .beacon_vision import BeaconVision as BeaconVision

"""Import and export of worlds.

In: maps of ROS map_server and Nav2, drawings in SVG and DXF, MATLAB configurations, scenes of Gazebo, MuJoCo and
    Webots, robots, mazes, cluttered rooms, BARN, templates. Out: maps, SDF, plans in SVG.
"""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)

"""A robot from a file of MJCF with a drive of the user's own."""

ROVER = """
<mujoco>
  <compiler angle="degree"/>
  <worldbody>
    <body name="base">
      <freejoint/>
      <geom type="box" size="0.2 0.12 0.05" pos="0 0 0.1" mass="4" rgba="0.2 0.5 0.8 1"/>
      <geom type="sphere" size="0.04" pos="-0.15 0 0.04" mass="0.1" condim="1" friction="0 0 0" priority="1"/>
      <geom type="sphere" size="0.04" pos="0.15 0 0.04" mass="0.1" condim="1" friction="0 0 0" priority="1"/>
      <body name="left" pos="0 0.15 0.08">
        <joint name="left" axis="0 1 0" armature="0.05"/>
        <geom type="ellipsoid" size="0.08 0.02 0.08" mass="0.3"/>
      </body>
      <body name="right" pos="0 -0.15 0.08">
        <joint name="right" axis="0 1 0" armature="0.05"/>
        <geom type="ellipsoid" size="0.08 0.02 0.08" mass="0.3"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <velocity name="left" joint="left" kv="4"/>
    <velocity name="right" joint="right" kv="4"/>
  </actuator>
</mujoco>
"""
TANK = """
class Tank:
    wheels = ("left", "right")

    def __init__(self, radius, track):
        self.radius, self.track = radius, track

    def wheels_from_twist(self, forward, left, turn):
        half = turn * self.track / 2
        return (forward - half) / self.radius, (forward + half) / self.radius

    def twist_from_wheels(self, speeds):
        left, right = speeds
        return self.radius * (left + right) / 2, 0.0, self.radius * (right - left) / self.track
"""
WORLD = """
mjsim: 1
walls: [{points: [[3, -2], [3, 2]]}]
robots:
  - {name: rover, at: [0, 0], odometry: {noise: {}}, body: {model: rover.xml, radius: 0.25, height: 0.15},
     drive: {use: "tank.py:Tank", radius: 0.08, track: 0.3, max_speed: 0.5}}
"""

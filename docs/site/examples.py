"""Examples of the Python reference, each of the classes in its heading; a test runs them in this order.

`seen` is an `Observation`, `robot` a `RobotInfo`.
"""

# %% Simulation, Observation, World
import mjsim

world = mjsim.load_world("sensors")
pose = mjsim.Pose(0, 0, 0)  # in the frame of the start
with mjsim.Simulation(world, seed=1) as sim:
    for _ in range(20):
        seen = sim.sense("scout")
        pose @= mjsim.Pose(seen.odometry.forward, seen.odometry.left, seen.odometry.turn)
        sim.apply("scout", mjsim.Command(forward=0.3))
        sim.step()
    seen = sim.sense("scout")
    print(f"{sim.time:.2f} s: {sim.truth('scout')}, dead reckoning {pose}")


# %% Estimator, RobotInfo, BeaconInfo, MarkerInfo, SensorInfo, Driver
class Reckoning:
    def start(self, robot, catalogue, rng):
        print(robot.drive, robot.sensors["front"].rate_hz, {name: info.marker for name, info in catalogue.items()})
        self.pose, self.covariance = robot.prior, robot.prior_covariance

    def update(self, seen):
        self.pose @= mjsim.Pose(seen.odometry.forward, seen.odometry.left, seen.odometry.turn)
        return mjsim.Estimate(self.pose, self.covariance)


driver = mjsim.Driver(estimator=Reckoning())


# %% Navigator, TakesGoals, SaysBlocked, Message
class ToGoal:
    def start(self, robot, map, rng):
        self.goal, self.max_speed = (2.0, 1.0), robot.max_speed

    def take_goal(self, x, y, heading):
        self.goal = x, y

    def command(self, seen, belief):
        ahead, left = belief.pose.inverse().transform(self.goal)
        for message in seen.messages:
            print(message.sender, message.content)
        return mjsim.Command(forward=min(0.5 * ahead, self.max_speed), turn=2 * left, messages=("on my way",))

    def blocked(self):
        return None  # or a reason, such as "a door is closed"


# %% Observer, Detection, CameraFrame
import numpy as np


class Brightest:
    def start(self, robot, catalogue, rng):
        self.robot_from_camera = robot.sensors["front"].robot_from_sensor

    def observe(self, seen):
        if (frame := seen.cameras.get("front")) is None:  # not due at this tick
            return []
        row, column = np.unravel_index(frame.image.sum(axis=2).argmax(), frame.image.shape[:2])
        lens = frame.intrinsics
        ray = np.array([(column - lens.cx) / lens.fx, (row - lens.cy) / lens.fy, 1.0])
        found = mjsim.Detection(name="lamp", position=2.0 * ray, covariance=0.1 * np.eye(3))
        return mjsim.sightings_from([found], self.robot_from_camera, frame.stamp)


# %% Avoidance
class SlowDown:
    def start(self, robot, rng):
        self.distance = 0.5

    def adjust(self, command, seen):
        near = min(seen.proximity[[15, 0, 1]].min() / self.distance, 1.0)  # ahead, and beside it
        return mjsim.Command(command.forward * near, command.left, command.turn)


# %% Controller, ControlLoop, FastReading, JointState, BalancingInfo, ArmInfo
class Damping:
    def start(self, robot, part, rng):
        self.arm = robot.arms[part]

    def torques(self, sensed, wanted):
        return np.clip(-2.0 * sensed.joints.velocities, -self.arm.max_torque, self.arm.max_torque)


loop = mjsim.ControlLoop(controller=Damping(), rate_hz=250, latency=1)


# %% DriveModel, WheelCommand
class Tank:
    wheels = ("left", "right")  # hinges of the model

    def wheels_from_twist(self, forward, left, turn):
        return (forward - 0.15 * turn) / 0.08, (forward + 0.15 * turn) / 0.08

    def twist_from_wheels(self, speeds):
        return 0.04 * (speeds[0] + speeds[1]), 0.0, 0.08 * (speeds[1] - speeds[0]) / 0.3


command = mjsim.WheelCommand(Tank().wheels_from_twist(0.3, 0, 0))


# %% TakesMap, HasPath, SaysLost, WorldMap
class WithMap(Reckoning):
    def take_map(self, map):
        self.walls = None if map is None else map.segments  # (n, 2, 2), world frame [m]

    def path(self):
        return [(0.0, self.pose)]

    def lost(self):
        return False


# %% Scan, PointCloud, ImuReading, WheelTicks, CompassReading, AnchorRanges
if "scan" in seen.scans:
    print(seen.scans["scan"].points().shape)  # (n, 2), in the plane of the sensor [m]
if "top" in seen.clouds:
    print(seen.clouds["top"].points.shape)  # (n, 3)
print([reading.turn[2] for reading in seen.imu])  # rates about z [rad/s]
for ticks in seen.encoders.values():
    print(ticks.counts)
for compass in seen.compasses.values():
    print(compass.heading, compass.variance)
for tag in seen.ranges.values():
    print(tag.ranges)  # anchor -> range [m]

# %% JointGoal
goal = mjsim.JointGoal(positions=(0.0, 0.5), velocities=(0.0, 0.1))
command = mjsim.Command(joints={"arm": goal})

# %% Shown, ShownPoints, ShownLines, ShownGrid, ShownText
show = (
    mjsim.ShownPoints(name="particles", points=np.zeros((100, 2)), size=0.03),
    mjsim.ShownLines(name="plan", points=[[0, 0], [1, 0], [1, 1]]),
    mjsim.ShownGrid(name="map", cells=[[0.1, 0.9]], resolution=0.5, origin=mjsim.Pose(0, 0, 0)),
    mjsim.ShownText(name="note", text="here", at=(0, 1)),
)
estimate = mjsim.Estimate(pose, 0.01 * np.eye(3), show=show)

# %% Recording, Tick
recording = mjsim.run("empty", seconds=1, record="run.mcap")
track = recording.robots["scout"]
print(recording.time[-1], track.truth[-1], track.estimate[-1])
with mjsim.Simulation(mjsim.load_world("empty")) as sim:
    tick = next(mjsim.ticks(sim, {}))
    print(tick.time, tick.truth["scout"])

# %% Session, Watcher
with mjsim.Session(mjsim.load_world("empty"), seconds=1) as session:
    for tick in session.watch():  # the newest each time
        print(tick.time)
    session.result()

# %% Studio
with mjsim.Studio(".", port=0) as studio:
    print(studio.url)

# %% JudgedPicture
for name, picture in mjsim.judge_pictures(world).items():
    print(name, picture.distance, picture.fault or "good")

# %% MjsimError, ModuleFault, OpenGLError, PhysicsFault, RecordingError, UsageError, WorldError
try:
    mjsim.parse_world("robots: [{name: scout, at: [0]}]")
except mjsim.WorldError as error:
    print(error.exit_code, error.problems[0])

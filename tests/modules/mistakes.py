"""Mistakes that modules make, and what the line about each says."""

import pytest

from tests.modules.faulty import written

RAISED = [
    # What a module raises: role, body, what the line says after 'at 0.20 s'.
    ("estimator", "1 / 0", r"raised ZeroDivisionError: .*zero \(bad\.py:\d+\)"),
    ("estimator", "sys.exit(3)", r"raised SystemExit: 3 \(bad\.py:\d+\)"),
    ("navigator", "sys.exit()", r"raised SystemExit \(bad\.py:\d+\)"),
    ("navigator", "raise SystemExit('bye')", r"raised SystemExit: bye \(bad\.py:\d+\)"),
    (
        "observer",
        "return self.observe(seen)",
        r"raised RecursionError: maximum recursion depth exceeded.* \(bad\.py:\d+\)",
    ),
    ("observer", "raise MemoryError", r"raised MemoryError \(bad\.py:\d+\)"),
    ("observer", "np.zeros((1 << 40, 1 << 20))", r"raised (ValueError|_?\w*MemoryError): .* \(bad\.py:\d+\)"),
    ("estimator", "raise GeneratorExit", r"raised GeneratorExit \(bad\.py:\d+\)"),
    ("estimator", "raise StopIteration", r"raised StopIteration \(bad\.py:\d+\)"),
    ("estimator", "raise type('Own', (BaseException,), {})('mine')", r"raised Own: mine \(bad\.py:\d+\)"),
    (
        "estimator",
        "raise mjsim.UsageError('one\\n  two\\n\\nthree')",
        r"raised UsageError: one two three \(bad\.py:\d+\)",
    ),
    ("estimator", "raise ValueError('x' * 100_000)", r"raised ValueError: x{240}\.\.\. \(bad\.py:\d+\)"),
    ("estimator", "raise ValueError('\\x1b[31m red')", r"raised ValueError: \\x1b\[31m red \(bad\.py:\d+\)"),
    (
        "estimator",
        "raise type('Mute', (Exception,), {'__str__': lambda self: 1 / 0})",
        r"raised Mute: its text cannot be read \(bad\.py:\d+\)",
    ),
    (
        "navigator",
        "raise ExceptionGroup('two', [ValueError(), OSError()])",
        r"raised ExceptionGroup: two .* \(bad\.py:\d+\)",
    ),
    (
        "navigator",
        "import nowhere_to_be_found",
        r"raised ModuleNotFoundError: No module named 'nowhere_to_be_found' \(",
    ),
    ("navigator", "return self.velocity", r"raised AttributeError: 'Bad' object has no attribute 'velocity' \("),
    ("estimator", "np.linalg.inv(np.zeros((3, 3)))", r"raised LinAlgError: Singular matrix \(bad\.py:\d+\)"),
    ("estimator", "warnings.simplefilter('error'); np.float64(1) / 0", r"raised RuntimeWarning: divide by zero .* \("),
    ("avoidance", "assert False, 'never'", r"raised AssertionError: never \(bad\.py:\d+\)"),
    ("observer", "seen.time = 3", r"raised FrozenInstanceError: cannot assign to field 'time' \(bad\.py:\d+\)"),
    (
        "observer",
        "seen.odometry.covariance[:] = 0",
        r"raised ValueError: .* read-only; .* copy it first \(bad\.py:\d+\)",
    ),
    ("estimator", "seen.sightings[0].covariance[0, 0] = 9", r"raised ValueError: .* copy it first \(bad\.py:\d+\)"),
    ("estimator", "seen.scans['scan'].ranges[0] = 9", r"raised ValueError: .* copy it first \(bad\.py:\d+\)"),
    ("navigator", "seen.scans.clear()", r"raised TypeError: what a module is given is read-only; copy it first \("),
    ("estimator", "self.robot.prior_covariance[0, 0] = 1", r"raised ValueError: .* copy it first \(bad\.py:\d+\)"),
    ("estimator", "del self.robot.sensors['ring']", r"raised TypeError: .* read-only; copy it first \(bad\.py:\d+\)"),
]
RETURNED = [
    # What a module returns.
    ("estimator", "return None", r"returned None; it must be an Estimate \(bad\.py:\d+\)"),
    ("estimator", "return mjsim.Estimate", r"returned the class Estimate; it must be an Estimate \("),
    ("estimator", "return (ORIGIN, EYE)", r"returned a value of type tuple; it must be an Estimate \("),
    ("estimator", "async def later(): pass\nreturn later()", r"returned a coroutine, .*; it must be an Estimate \("),
    (
        "estimator",
        "return mjsim.Estimate((0, 0, 0), EYE)",
        r"returned a pose that is a value of type tuple; it must be a Pose",
    ),
    ("estimator", "return mjsim.Estimate(None, EYE)", r"returned a pose that is None; it must be a Pose \("),
    (
        "estimator",
        "return mjsim.Estimate(mjsim.Pose('1', 0, 0), EYE)",
        r"a pose that holds something other than numbers: '1'",
    ),
    (
        "estimator",
        "return mjsim.Estimate(mjsim.Pose(1j, 0, 0), EYE)",
        r"returned a pose that is complex; it must be real",
    ),
    (
        "estimator",
        "return mjsim.Estimate(mjsim.Pose(np.zeros(1), 0, 0), EYE)",
        r"returned a pose that holds an array of shape \(1,\); it must hold plain numbers",
    ),
    (
        "estimator",
        "return mjsim.Estimate(mjsim.Pose(10**400, 0, 0), EYE)",
        r"cannot be read: OverflowError: int too large",
    ),
    (
        "estimator",
        "return mjsim.Estimate(mjsim.Pose(np.inf, 0, 0), EYE)",
        r"a pose that is not finite: \[inf, 0\.0, 0\.0\]",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, None)",
        r"returned the covariance of the pose of shape \(\); it must be \(3, 3\)",
    ),
    ("estimator", "return mjsim.Estimate(ORIGIN, np.eye(2))", r"pose of shape \(2, 2\); it must be \(3, 3\)"),
    ("estimator", "return mjsim.Estimate(ORIGIN, np.zeros((3000, 3000)))", r"pose of shape \(3000, 3000\); it must be"),
    ("estimator", "return mjsim.Estimate(ORIGIN, [[1], [1, 2], [3]])", r"of the pose whose rows differ in length"),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE.astype(str))",
        r"of the pose that holds something other than numbers: \['1",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE * np.nan)",
        r"the covariance of the pose that is not finite: \[\[nan",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, -EYE)",
        r"covariance of the pose with the eigenvalue -1; a covariance has none below 0",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE * (1 + 0j))",
        r"the covariance of the pose that is complex; it must be real",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]))",
        r"of the pose that is not symmetric: entry \[0, 1\] is 0\.5, \[1, 0\] is 0 \(",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, np.array([[1, 2, 0], [2, 1, 0], [0, 0, 1]]))",
        r"of the pose with the eigenvalue -1;",
    ),
    (
        "estimator",
        "class Odd:\n    def __array__(self, *a, **k): raise OSError('no')\nreturn mjsim.Estimate(ORIGIN, Odd())",
        r"returned a value of type Estimate that cannot be read: OSError: no \(bad\.py:\d+\)",
    ),
    (
        "estimator",
        "class Odd(mjsim.Estimate):\n    @property\n    def covariance(self): raise KeyError('P')\n"
        "return Odd.__new__(Odd)",
        r"returned a value of type Odd that cannot be read: (AttributeError|KeyError): ",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, [('lion', np.zeros(2))])",
        r"returned landmarks that are a value of type list; they must be a dict: name -> \(mean, covariance\) \(",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {'lion': np.zeros(2)})",
        r"returned landmark 'lion' that is a value of type",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {'lion': (np.zeros(3), np.eye(2))})",
        r"mean of landmark 'lion' of shape \(3,\)",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {7: (np.zeros(2), -np.eye(2))})",
        r"covariance of landmark 7 with the eigenvalue -1;",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {}, (x for x in ()))",
        r"returned innovations that are a value of type generator",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {}, [('lion', np.zeros(2))])",
        r"an innovation that is a value of type tuple of 2",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {}, ((['lion'], np.zeros(2), np.eye(2)),))",
        r"returned an innovation whose name is a value of type list; it must be hashable",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {}, (('lion', np.zeros(2), np.eye(3)),))",
        r"the covariance of the innovation of 'lion' of shape \(3, 3\); it must be \(2, 2\)",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {}, (), np.eye(4))",
        r"returned the joint covariance of shape \(4, 4\); it must be \(3, 3\)",
    ),
    (
        "estimator",
        "return mjsim.Estimate(ORIGIN, EYE, {}, (), np.diag([1.0, 1.0, -4.0]))",
        r"returned the joint covariance with the eigenvalue -4;",
    ),
    ("observer", "return None", r"returned None; it must be a list of Sighting \("),
    ("observer", "return 'lion'", r"returned a value of type str; it must be a list of Sighting"),
    ("observer", "return (s for s in ())", r"returned a value of type generator; it must be a list of Sighting"),
    ("observer", "return ['lion']", r"returned a value of type str in its list; each must be a Sighting"),
    (
        "observer",
        "return [mjsim.Sighting(0.2, 'lion', -1.0, 0.0, np.eye(2))]",
        r"returned a sighting at range -1 m; it must not be negative \(",
    ),
    (
        "observer",
        "return [mjsim.Sighting(0.2, 'lion', 1.0, np.nan, np.eye(2))]",
        r"returned a sighting that is not finite",
    ),
    (
        "observer",
        "return [mjsim.Sighting(0.2, 5, 1.0, 0.0, np.eye(2))]",
        r"a sighting whose name is a value of type int",
    ),
    (
        "observer",
        "return [mjsim.Sighting(0.2, None, 1.0, 0.0, -np.eye(2))]",
        r"covariance of a sighting with the eigenvalue -1;",
    ),
    (
        "observer",
        "return [mjsim.Sighting(0.2, None, 1.0, 0.0, np.eye(2), EYE)]",
        r"corners of a sighting of shape \(3, 3\)",
    ),
    ("navigator", "return None", r"returned None; it must be a Command or a WheelCommand \("),
    ("navigator", "return (0.1, 0.0, 0.0)", r"returned a value of type tuple; it must be a Command or a WheelCommand"),
    ("navigator", "return mjsim.Command(np.nan)", r"returned a command that is not finite: \[nan, 0\.0, 0\.0\]"),
    ("navigator", "return mjsim.Command(None)", r"returned a command that holds something other than numbers: None"),
    ("navigator", "return mjsim.Command(1j)", r"returned a command that is complex; it must be real"),
    (
        "navigator",
        "return mjsim.WheelCommand(None)",
        r"returned wheel speeds that are None; the wheels are wheel_left, wheel_right",
    ),
    (
        "navigator",
        "return mjsim.WheelCommand((1.0,))",
        r"returned 1 wheel speeds; the wheels are wheel_left, wheel_right",
    ),
    (
        "navigator",
        "return mjsim.WheelCommand(s for s in (1, 2))",
        r"returned wheel speeds that are a value of type generator;",
    ),
    (
        "navigator",
        "return mjsim.Command(messages='hello')",
        r"returned messages that are a value of type str; they must be a tuple",
    ),
    (
        "navigator",
        "return mjsim.Command(messages=(object(),))",
        r"returned a message that cannot be sent \(a value of type object",
    ),
    (
        "navigator",
        "return mjsim.Command(messages=(np.nan,))",
        r"returned a message that cannot be sent \(Out of range float",
    ),
    (
        "navigator",
        "class Odd(dict):\n    def items(self): raise OSError('no')\nreturn mjsim.Command(messages=(Odd(a=1),))",
        r"returned a value of type Command that cannot be read: OSError: no \(bad\.py:\d+\)",
    ),
    ("avoidance", "return None", r"returned None; it must be a Command or a WheelCommand \("),
    ("avoidance", "return mjsim.Command(np.inf)", r"returned a command that is not finite"),
]
STARTED = [
    # What goes wrong before the first tick: role, the file, what the line says after 'at 0.00 s'.
    ("estimator", written("estimator", "", start="1 / 0"), r"raised ZeroDivisionError: .* \(bad\.py:\d+\)"),
    ("navigator", written("navigator", "", start="sys.exit(4)"), r"raised SystemExit: 4 \(bad\.py:\d+\)"),
    (
        "estimator",
        written("estimator", "").replace("robot, catalogue, rng", "robot"),
        r"raised TypeError: Bad\.start\(\) takes 2 positional arguments but 4 were given \(bad\.py:\d+\)",
    ),
    (
        "navigator",
        written("navigator", "").replace("class Bad:", "class Bad:\n    def take_map(self, map): map.segments[:] = 0"),
        r"raised ValueError: .* copy it first \(bad\.py:\d+\)",
    ),
    (
        "observer",
        written("observer", "").replace("class Bad:", "class Bad:\n    take_map = property(lambda self: 1 / 0)"),
        r"raised ZeroDivisionError: .* \(bad\.py:\d+\)",
    ),
    (
        "observer",
        written("observer", "", start="catalogue.clear()"),
        r"raised TypeError: what a module is given is read-only; copy it first \(bad\.py:\d+\)",
    ),
    (
        "estimator",
        written("estimator", "yield"),
        r"returned a value of type generator; it must be an Estimate \(bad\.py:\d+\)",
    ),
]


def cases() -> list:
    """Return (role, module, what its line says) of all mistakes."""
    late = [(role, written(role, body), f"at 0.20 s .*{says}") for role, body, says in (*RAISED, *RETURNED)]
    early = [(role, text, f"at 0.00 s .*{says}") for role, text, says in STARTED]
    return [pytest.param(role, text, says, id=f"{role}-{says[12:60]}") for role, text, says in (*late, *early)]

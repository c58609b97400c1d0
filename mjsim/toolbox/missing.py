"""Functions that a script calls and the toolbox lacks: one line that names an alternative."""

import re

from mjsim.errors import did_you_mean
from mjsim.modules import TOOLBOX

UNDEFINED = re.compile(r"'(\w+)' undefined(?: near line \d+, column \d+)?")
USAGE = re.compile(r"Invalid call to (\w+)\.\s+Correct usage is:\s+-- (.*?)(?= -- | \(\S+:\d+\)$|$)")
NOT_INSTALLED = re.compile(r"package (\w+) is not installed")
MIN_NAME_LENGTH = 3
"""Shorter names are variables that are missing."""
PACKAGE = re.compile(r"belongs to the (\w+) package from Octave Forge which seems to not")
INSTEAD = (
    (
        r"rigidBody\w*|\w*nverseKinematics|loadrobot|importrobot|DHFactor|ETS\d?|trapveltraj",
        "arms are made by robot and link, or SerialLink and Link, and move by jtraj, ctraj and mtraj",
    ),
    (
        r"lidarScan|lidarSLAM|matchScans\w*|\w*[oO]ccupancyMap\w*|\w*[oO]ccupancyGrid|monteCarloLocalization",
        "maps and scans belong to a world, as with the module LidarSlam",
    ),
    (
        r"planner\w+|stateSpace\w+|validator\w+|controller\w+|\w+Kinematics|mobileRobotPRM|PRM|RRT|Bug2|D?star|DXform"
        r"|EKF|ParticleFilter|Vehicle|Bicycle|Unicycle|LandmarkMap|RangeBearingSensor",
        "drivers, planners and filters are modules of a world, such as GoToGoal and EkfSlam",
    ),
    (
        r"SE[23]|SO[23]|se[23]|so[23]|Twist|\w+2(rotm|tform|eul|quat|axang|trvec)",
        "poses are 4 x 4 matrices of transl, trotx, rpy2tr, eul2tr and angvec2tr; quaternion serves rotations",
    ),
    (
        r"tf|ss|zpk|step|bode\w*|nyquist|nichols|margin|rlocus|lqr|place|pid|feedback|pzmap|lsim|impulse|c2d|rltool|sisotool",
        "install octave-control and write pkg load control, or write the plant for mjsim lab",
    ),
    (
        r"p560|q[zrns]|qstretch|stanf",
        "puma560 or mdl_puma560 at the top makes p560, qz, qr, qn and qstretch, and stanford makes stanf and qz",
    ),
    (
        r"tripleangle|joystick|gui_mainfcn|guide|uifigure|uislider|uibutton|uiaxes|appdesigner|rtbdemo|rtdemo",
        "windows do not exist here; drivebot(r) and teach(r) have sliders with --studio",
    ),
    (
        r"\w*Camera|iread|idisp|homography|isurf",
        "cameras and their pictures belong to a world",
    ),
    (
        r"sim|set_param|load_system|open_system|sl_\w+|simset|simulink",
        "models of Simulink do not run here: write the loop with fdyn, ode45 or for",
    ),
    (
        r"puma560akb|mdl_\w+",
        "shipped arms are mdl_puma560, mdl_stanford, mdl_twolink, mdl_planar1, 2 and 3; make others of links",
    ),
    (
        r"table|timetable|\w+2table|readtable|writetable|readmatrix|writematrix",
        "Octave has no tables: columns are vectors, printed by fprintf and read by csvread or textscan",
    ),
    (
        r"plot_\w+",
        "draw with plot, plot3 and quiver; plot(r, q) draws and films an arm",
    ),
)
"""Names of other toolboxes, as patterns, and alternatives to them."""


MEMBERS = {
    "member 'type'": "links have no type: sigma is 0 of a joint that turns, and 1 of one that slides",
    "member 'A'": "links have no methods: the matrix of joint k is r.A(k, q) of an arm",
    "member 'dyn'": "links have no methods: dyn(r) prints the masses of an arm",
}
"""Methods of links, which are structs here."""


def explained(error: str) -> str:
    """Return an error of Octave; for an undefined name with an alternative, if one is known."""
    if "structure has no member" in error or "invalid use of a N_-D array" in error:
        return next((error.replace(name, f"{name}; {told}") for name, told in MEMBERS.items() if name in error), error)
    if called := USAGE.match(error):
        known = next((told for names, told in INSTEAD if re.fullmatch(names, called[1])), None)
        place = re.search(r" \(\S+:\d+\)$", error)
        told = f"; {known}" if known else f"; it is {called[2].strip()}"
        return f"'{called[1]}' is called with too few or too many arguments{told}{place[0] if place else ''}"
    if absent := NOT_INSTALLED.search(error):
        return f"{error[: absent.end()]}; install octave-{absent[1]}{error[absent.end() :]}"
    if "FILE argument must not be empty" in error:
        return f"windows made by GUIDE do not exist here{error[error.rindex(' (') :] if ' (' in error else ''}"
    found = UNDEFINED.search(error)
    if found is None:
        return error
    name = found[1]
    known = next((told for names, told in INSTEAD if re.fullmatch(names, name)), None)
    package = PACKAGE.search(error)
    if known is None and package is not None:
        known = f"install octave-{package[1]} and write pkg load {package[1]}"
    ours = [file.stem for file in TOOLBOX.glob("*.m") if not file.stem.startswith("mjsim_")]
    near = did_you_mean(name, ours) if len(name) >= MIN_NAME_LENGTH else ""
    told = f"'{name}' undefined" + (f"; {known}" if known else near if "did you mean" in near else "")
    place = re.search(r" \(\S+:\d+\)$", error)
    return f"{error[: found.start()]}{told}{place[0] if place else ''}"

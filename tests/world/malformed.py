"""Malformed texts of worlds, and what is said of each."""

ROBOT = "robots: [{name: a, at: [1, 1]}]\n"
BOMB = "a: &a [1, 2, 3, 4, 5, 6, 7, 8, 9]\n" + "".join(
    f"{after}: &{after} [{', '.join([f'*{before}'] * 9)}]\n"
    for before, after in zip("abcdefgh", "bcdefghi", strict=True)
)
TEXTS = {
    # Not YAML, or not a world
    "empty": ("", "1:1: the file is empty; a world begins with 'mjsim: 1'"),
    "only a comment": ("# nothing\n", "1:1: the file is empty; a world begins with 'mjsim: 1'"),
    "a list": ("- mjsim: 1\n", "1:1: the file holds a list; a world begins with 'mjsim: 1'"),
    "a word": ("hello\n", "1:1: the file holds one value; a world begins with 'mjsim: 1'"),
    "a bracket left open": (
        "walls: [\n  {points: [[0, 0], [1, 0]]}\n",
        "3:1: this is not YAML: expected ',' or ']', but got '<stream end>'; is the bracket opened at 1:8 closed?",
    ),
    "a quote left open": ("name: 'room\n", "2:1: this is not YAML: found unexpected end of stream"),
    "a tab": ("floor:\n\ttile: 1\n", "2:1: this is not YAML: a tab is where YAML needs spaces; indent with spaces"),
    "a colon too many": ("name: a: b\n", "1:8: this is not YAML: mapping values are not allowed here"),
    "two documents": ("mjsim: 1\n---\nmjsim: 1\n", "2:1: a second document begins here; a world file holds one"),
    "an unknown alias": ("walls: *none\n", "1:8: alias '*none' has no anchor '&none' before it"),
    "an anchor within itself": ("walls: &w [*w]\n", "1:12: alias '*w' is inside its own anchor '&w'"),
    "a YAML bomb": (BOMB, "6:16: the text holds more than 250000 values, with aliases expanded; use fewer"),
    "a deep nest": ("walls: " + "[" * 100_000, "1:57: values are nested more than 50 deep; write them flatter"),
    "a deep nest of keys": ("{a: " * 5000, "1:201: values are nested more than 50 deep; write them flatter"),
    "a Python object": (
        "name: !!python/object/apply:os.system [ls]\n",
        "1:7: tag '!!python/object/apply:os.system' is not allowed; write a plain value",
    ),
    "a control character": ("name: a\x07b\n", "1:8: character U+0007 is not text; write the file as UTF-8 text"),
    "half a character": ('name: "\\ud800"\n', "1:7: '\\ud800' holds a character that is not text; leave it out"),
    "a character beyond Unicode": ('name: "\\UFFFFFFFF"\n', "1:1: this is not YAML: the value that follows has an"),
    "another version": ("mjsim: 2\n", "1:8: mjsim is 2; it must be 1"),
    # Keys
    "a merge key": (
        "robots: [&r {name: a, at: [1, 1]}, {<<: *r, name: b, at: [2, 2]}]\n",
        "1:36: merge key '<<' is not supported; write its keys out",
    ),
    "a misspelt key": ("mjsim: 1\nwals: []\n", "2:1: unknown key 'wals'; did you mean 'walls'?"),
    "a misspelt key in a list": (
        "walls:\n  - points: [[0, 0], [1, 0]]\n    heigth: 2\n",
        "3:5: unknown key 'heigth'; did you mean 'height'?",
    ),
    "a misspelt key of an opening": (
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, widht: 1}]}]",
        "1:55: unknown key 'widht'; did you mean 'width'?",
    ),
    "a misspelt kind of obstacle": (
        "obstacles: [{boxs: [1, 1, 1], at: [0, 0]}]",
        "1:14: unknown key 'boxs'; did you mean 'box'?",
    ),
    "an obstacle without a kind": (
        "obstacles: [{at: [0, 0]}]",
        "1:13: obstacles[0] is {at}; an obstacle needs its shape",
    ),
    "a misspelt shape": ("obstacles: [{cylindr: [1, 1], at: [0, 0]}]", "1:14: unknown key 'cylindr'; did you mean"),
    "a misspelt key of a sensor": (
        "robots: [{name: a, at: [1, 1], sensors: [{camera: c, fov: 60}]}]",
        "1:54: unknown key 'fov'; did you mean 'fov_deg'?",
    ),
    "a misspelt key of noise": (
        "robots: [{name: a, at: [1, 1], drive: {noise: {sped: 0.1}}}]",
        "1:48: unknown key 'sped'; did you mean 'speed'?",
    ),
    "a misspelt key of the view": ("run: {view: {folow: truth}}", "1:14: unknown key 'folow'; did you mean 'follow'?"),
    "a misspelt module": (
        ROBOT + "run: {drivers: {a: {estimater: {use: 'a:B'}}}}",
        "2:21: unknown key 'estimater'; did you mean 'estimator'?",
    ),
    "a key written twice": (
        "floor:\n  tile: 1\n  tile: 2\n",
        "3:3: key 'tile' is written twice, first in line 2; keep one",
    ),
    "a key that is a number": ("3: x\n", "1:1: key 3 is not text; put it in quotes or write a name"),
    "a missing key": ("robots:\n  - name: a\n", "2:5: key 'at' is missing; add it: initial position, [x, y] [m]"),
    # Values
    "a negative height": (
        "walls:\n- points: [[0, 0], [1, 0]]\n  height: -2.0\n",
        "3:11: height is -2.0 m; it must be above 0",
    ),
    "a negative size of a box": (
        "obstacles: [{box: [1, -1, 1], at: [0, 0]}]",
        "1:23: box[1] is -1 m; it must be above 0",
    ),
    "a size of zero": ("floor: {tile: 0}", "1:15: tile is 0 m; it must be above 0"),
    "a size that no mesh has": ("floor: {tile: 1.e-9}", "1:15: a length is 1e-09 m; it must be at least 1e-05 m"),
    "NaN": ("robots: [{name: a, at: [.nan, 1]}]", "1:25: at[0] is nan; it must be a finite number"),
    "infinity": ("run: {seconds: .inf}", "1:16: seconds is inf; it must be a finite number"),
    "a number that overflows": ("run: {seconds: 1e999}", "1:16: seconds is inf; it must be a finite number"),
    "a number of many digits": ("run: {seed: " + "9" * 5000 + "}", "1:13: a number of 5000 digits; write at most 30"),
    "a seed too large": ("run: {seed: 9223372036854775808}", "1:13: seed is 9223372036854775808; it must be below"),
    "a word for a number": ("floor: {friction: rough}", "1:19: friction is 'rough'; it must be a number"),
    "a number in quotes": ("floor: {friction: '1'}", "1:19: friction is '1'; it must be a number"),
    "a truth for a number": ("floor: {friction: true}", "1:19: friction is true; it must be a number"),
    "a yes for a truth": (
        "walls: [{points: [[0, 0], [1, 0]], closed: yes}]",
        "1:44: closed is 'yes'; it must be true or",
    ),
    "a fraction for a count": ("run: {seed: 1.5}", "1:13: seed is 1.5; it must be a whole number"),
    "nothing for a list": ("walls:\n", "1:1: walls is empty; it must be a list"),
    "keys for a list": ("walls: {points: []}", "1:8: walls is {points}; it must be a list"),
    "a list for keys": ("floor: [1]", "1:8: floor is [1]; it must be keys with values"),
    "three coordinates": ("robots: [{name: a, at: [1, 1, 1]}]", "1:24: at is [1, 1, 1]; it must be [x, y]"),
    "one corner": ("walls: [{points: [[0, 0]]}]", "1:18: points is [[0, 0]]; it must have at least 2 items"),
    "two corners at one place": (
        "walls: [{points: [[0, 0], [0, 0]]}]",
        "1:18: points[0] and points[1] are both [0, 0]; make them differ",
    ),
    "a colour by name": (
        "floor: {color: red}",
        "1:16: color is 'red'; it must be a colour such as \"#e8e4da\", in quotes",
    ),
    "a colour taken for a comment": (
        "floor: {color: #e8e4da}\n",
        "2:1: this is not YAML: expected the node content, but found '<stream end>'",
    ),
    "a name with a slash": ("name: ../room", "1:7: name is '../room'; it must be a name of letters, digits,"),
    "an unknown choice": (
        "run: {map: knwon}",
        "1:12: map is 'knwon'; it must be 'unknown' or 'known'; did you mean 'known'?",
    ),
    "a head below the sill": (
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1, sill: 2, head: 1}]}]",
        "1:80: head is 1.0 m; it must be above the sill at 2.0 m",
    ),
    "a segment that is not there": (
        "walls: [{points: [[0, 0], [4, 0]], openings: [{segment: 1, at: 1, width: 1}]}]",
        "1:57: segment is 1; this wall has segments 0 to 0",
    ),
    # What does not fit together
    "an unknown preset": ("robots: [{name: a, at: [1, 1], preset: pioner}]", "1:40: no preset 'pioner'; did you mean"),
    "a fault in an override": (
        "robots:\n- name: a\n  at: [1, 1]\n  preset: pioneer3dx\n  drive: {track: -1}\n",
        "5:18: track is -1 m; it must be above 0",
    ),
    "one name for two": (
        "beacons: [{name: a, at: [3, 3]}]\n" + ROBOT,
        "2:17: name 'a' is taken by beacons[0]; give each item its own",
    ),
    "one name for two sensors": (
        "robots: [{name: a, at: [1, 1], sensors: [{camera: c}, {camera: c}]}]",
        "1:64: name 'c' is taken by another sensor of this robot; give each its own",
    ),
    "a driver without a robot": (ROBOT + "run: {drivers: {b: {}}}", "2:17: no robot 'b' in this world; there are a"),
    "a tick between steps": (
        "run: {rate_hz: 30}",
        "1:16: rate_hz is 30 Hz; a tick must be a whole number of 4 ms steps, the nearest rate is 31.25 Hz",
    ),
    "a sensor between ticks": (
        "robots: [{name: a, at: [1, 1], sensors: [{camera: c, rate_hz: 10}]}]",
        "1:63: rate_hz is 10 Hz; it must divide the 25 Hz of the tick, the nearest is 8.33333 Hz",
    ),
    "a robot in a wall": (
        "walls: [{points: [[0, 0], [4, 0]]}]\nrobots: [{name: a, at: [2, 0.2]}]",
        "2:24: robot 'a' at [2, 0.2] starts inside walls[0]; its body needs 0.22 m free all around",
    ),
    "a beacon in a wall": (
        "walls: [{points: [[0, 0], [4, 0]]}]\nbeacons: [{name: b, at: [2, 0]}]",
        "2:25: beacon 'b' at [2, 0] hangs inside walls[0], where it cannot be seen; move it to a face",
    ),
    "an opening past its segment": (
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 3.5, width: 1}]}]",
        "1:64: this opening goes from 3.5 to 4.5 m; segment 0 is 4 m long, keep it within",
    ),
    "a class that is not there": (
        ROBOT + "run: {drivers: {a: {estimator: {use: 'mjsim.algorithms.ekf_slam:Ekf'}}}}",
        "2:38: no class 'Ekf' in mjsim.algorithms.ekf_slam; did you mean",
    ),
    "a module that is not there": (
        ROBOT + "run: {drivers: {a: {estimator: {use: 'nowhere.at.all:Ekf'}}}}",
        "2:38: no module 'nowhere' is installed; install it or correct the name",
    ),
    # Pictures
    "a picture that is not there": (
        "floor: {texture: none.png}",
        "1:18: no file 'none.png' beside the world file or in assets",
    ),
    "a path that leaves": (
        "floor: {texture: ../oak.png}",
        "1:18: path '../oak.png' is outside its folder; name a file",
    ),
    "a path as on Windows": (
        "floor: {texture: 'floors\\oak.jpg'}",
        "1:18: path 'floors\\oak.jpg' has a backslash; write / between folders",
    ),
    "a path from the root": (
        "floor: {texture: /etc/passwd}",
        "1:18: path '/etc/passwd' is outside its folder; name a file",
    ),
    "a path longer than a system takes": (
        f"floor: {{texture: {'é' * 190}}}",
        f"1:18: no file '{'é' * 190}' beside the world file or in assets",
    ),
    "a folder longer than a system takes": (
        f"floor: {{texture: {'é' * 190}/a.png}}",
        f"1:18: no file '{'é' * 190}/a.png' beside the world file or in assets",
    ),
    "an include longer than a system takes": (f"include: [{'a' * 300}]", f"1:11: no file '{'a' * 300}' beside the"),
    "a path through a link": (
        "floor: {texture: link/secret.png}",
        "1:18: path 'link/secret.png' is outside its folder",
    ),
    "a picture that is text": ("floor: {texture: world.yaml}", "1:18: 'world.yaml' is not a PNG or JPEG picture"),
    "a picture cut short": (
        "floor: {texture: short.png}",
        "1:18: 'short.png' is a truncated PNG picture; save it again",
    ),
    "a picture too large": (
        "floor: {texture: huge.png}",
        "1:18: 'huge.png' is a picture of 2500 megapixels; it must have",
    ),
    "a picture with no file name": ("floor: {texture: ''}", "1:18: texture is ''; it must have at least 1 character"),
}

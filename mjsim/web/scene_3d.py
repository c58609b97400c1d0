"""A compiled world for the page's view in 3-D: what it looks like, once, and where its bodies are at any state."""

import gzip
import json
import struct
import threading

import numpy as np
from starlette.responses import Response

from mjsim.geometry import Array
from mjsim.sim import StillScene, glb_bytes, moving_bodies
from mjsim.web.local import HEADERS
from mjsim.world import Looks, World

LEVEL = 5
"""Of compression; the next ones take longer than they save on the way."""


class Scene3d:
    """One world; from any thread."""

    def __init__(self, world: World) -> None:
        """Compile the world; it stands as at the start.

        Raises:
            UsageError: It cannot be compiled, or is too large to be given away.
        """
        self.world = world
        self._scene, self._lock = StillScene(world), threading.Lock()
        self._scene.show(self._scene.model.qpos0)
        self._bodies = np.unique(moving_bodies(self._scene.model))
        self._packed = gzip.compress(glb_bytes(self._scene.model, self._scene.data, sparing=True), LEVEL, mtime=0)

    def surfaces(self) -> Response:
        """Return the answer that gives the scene as it stands at the start, as glTF."""
        return Response(self._packed, media_type="model/gltf-binary", headers={**HEADERS, "Content-Encoding": "gzip"})

    def poses(self, time: float, qpos: Array, looks: Looks | None) -> bytes:
        """Return where the bodies of the scene are.

        That is the time [s] in 8 bytes, then in 4 each how many bodies and contacts there are; then numbers of 4
        bytes: for each body, in the order of its nodes in the glTF, x, y, z [m] and the quaternion x, y, z, w, world
        frame, and for each contact x, y, z [m] and 1 for one with the floor; then the names of what is no longer
        there, as JSON. All is little-endian.

        Args:
            time: Of the state [s].
            qpos: MuJoCo's positions, shape (nq,).
            looks: Light, and what is no longer there.

        Raises:
            UsageError: The state is not of this world.
        """
        with self._lock:
            self._scene.show(qpos, looks=looks)
            data = self._scene.data
            rows = np.column_stack([data.xpos[self._bodies], np.roll(data.xquat[self._bodies], -1, axis=1)])
            contacts = self._scene.contacts()
        numbers = np.concatenate([rows.ravel(), contacts.ravel()]).astype("<f4").tobytes()
        removed = json.dumps(sorted(looks.removed) if looks is not None else []).encode()
        return struct.pack("<dII", time, len(rows), len(contacts)) + numbers + removed


class Scene3dShelf:
    """The scene that was asked for last, of one world at a time; who asks meanwhile waits."""

    def __init__(self) -> None:
        """Be empty."""
        self._lock = threading.Lock()
        self._held: Scene3d | None = None

    def of(self, world: World) -> Scene3d:
        """Return the scene of a world, compiled if it is another than the one before.

        Raises:
            UsageError: It cannot be compiled, or is too large to be given away.
        """
        with self._lock:
            if self._held is None or self._held.world is not world:
                self._held = Scene3d(world)
            return self._held

    def held(self, world: World | None) -> Scene3d | None:
        """Return the scene of a world if it was asked for; None while it is compiled."""
        held = self._held
        return held if held is not None and held.world is world else None

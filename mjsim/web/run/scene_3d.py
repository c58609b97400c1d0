"""A compiled world for the 3-D view of the page: its appearance, once, and the poses of its bodies in any state."""

import gzip
import json
import struct
import threading

import numpy as np
from starlette.responses import Response

from mjsim.geometry import Array
from mjsim.sim import StillScene, glb_bytes, kept_light, moving_bodies
from mjsim.web.server import HEADERS
from mjsim.world import Looks, World

COMPRESSION_LEVEL = 5
"""Compression level; higher ones take longer than they save in transfer."""


class Scene3d:
    """The 3-D scene of one world; thread-safe."""

    def __init__(self, world: World) -> None:
        """Compile the world in its initial state.

        Raises:
            UsageError: It cannot be compiled, or is too large to be sent.
        """
        self.world = world
        self._scene, self._lock = StillScene(world), threading.Lock()
        # The page does not wait for light: it is there once a picture of this world has been drawn.
        light = kept_light(world, self._scene.model)
        self._scene.show(self._scene.model.qpos0)
        self._bodies = np.unique(moving_bodies(self._scene.model))
        self._packed = gzip.compress(
            glb_bytes(self._scene.model, self._scene.data, sparing=True, light=light), COMPRESSION_LEVEL, mtime=0
        )

    def surfaces(self) -> Response:
        """Return the response with the initial scene as glTF."""
        return Response(self._packed, media_type="model/gltf-binary", headers={**HEADERS, "Content-Encoding": "gzip"})

    def poses(self, time: float, qpos: Array, looks: Looks | None) -> bytes:
        """Return the poses of the bodies of the scene.

        Format, little-endian: the time [s] in 8 bytes; the numbers of bodies and of contacts in 4 bytes each; then
        values of 4 bytes: for each body, in the order of its nodes in the glTF, x, y, z [m] and the quaternion x, y, z,
        w, world frame, and for each contact x, y, z [m] and 1 for one with the floor; then the names of removed items
        as JSON.

        Args:
            time: Time of the state [s].
            qpos: Positions in MuJoCo's order, shape (nq,).
            looks: Light and removed items.

        Raises:
            UsageError: The state does not belong to this world.
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
    """The most recently requested scene, of one world at a time; concurrent requests wait."""

    def __init__(self) -> None:
        """Start empty."""
        self._lock = threading.Lock()
        self._held: Scene3d | None = None

    def of(self, world: World) -> Scene3d:
        """Return the scene of a world, compiled unless it is the current one.

        Raises:
            UsageError: It cannot be compiled, or is too large to be sent.
        """
        with self._lock:
            if self._held is None or self._held.world is not world:
                self._held = Scene3d(world)
            return self._held

    def held(self, world: World | None) -> Scene3d | None:
        """Return the scene of a world if it was requested before; None while it is compiled."""
        held = self._held
        return held if held is not None and held.world is world else None

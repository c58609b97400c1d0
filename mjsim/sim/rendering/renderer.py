"""Images, instances and depth of a scene, rendered off screen."""

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.closing import Closes
from mjsim.compile import general_light, lamp_lights, lamps_drawn
from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.sentences import Sentence
from mjsim.sim.rendering.canvas import Canvas, Quality
from mjsim.sim.rendering.in_view import Frustum, InView, frustum_of
from mjsim.sim.rendering.light_source import LightSource
from mjsim.sim.rendering.merged import UNSEEN, Merged

SEEN = (0, 1)
"""Geom groups that onboard cameras see."""
SEEN_FROM_OUTSIDE = (0, 1, 2)
"""Geom groups in views from outside: also masts and housings of cameras."""
CATEGORIES = mujoco.mjtCatBit.mjCAT_STATIC | mujoco.mjtCatBit.mjCAT_DYNAMIC
"""Static and moving objects, without decoration."""


def _flags(*shown: mujoco.mjtRndFlag) -> NDArray[np.uint8]:
    """Return MuJoCo's flags with these set, and back faces culled."""
    flags = np.zeros(mujoco.mjtRndFlag.mjNRNDFLAG, dtype=np.uint8)
    flags[[int(flag) for flag in (mujoco.mjtRndFlag.mjRND_CULL_FACE, *shown)]] = 1
    return flags


PICTURE = _flags()
PICTURE_HIGH = _flags(mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION)
INSTANCES = _flags(mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)
"""Flags for rendering instances."""


class Renderer(Closes):
    """Draws pictures of one size. Use from one thread at a time, and close when done."""

    def __init__(
        self,
        model: mujoco.MjModel,
        *,
        width: int,
        height: int,
        quality: Quality = "normal",
        canvas: Canvas | None = None,
        light: LightSource | None = None,
        groups: tuple[int, ...] = SEEN,
    ) -> None:
        """Initialise.

        Args:
            model: The model; its visual settings are used except for `quality`.
            width: [px]
            height: [px]
            quality: As for `Canvas`; ignored when a canvas is given.
            canvas: Canvas shared with other renderers of this model; by default its own.
            light: Light shared with them; by default its own.
            groups: Visible geom groups.
        """
        self._model = model
        self._canvas = canvas or Canvas(model, quality=quality, light=light)
        self._owns_canvas = canvas is None
        self._shape = height, width
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._merged = Merged(model)
        self._drawn = np.flatnonzero(np.isin(model.geom_group, groups))
        self._in_view = InView(model, self._drawn)
        self._apart = InView(model, np.union1d(self._drawn, self._merged.parts)) if len(self._merged.parts) else None
        self._lamps = lamp_lights(model)
        self._scene = mujoco.MjvScene(model, maxgeom=2 + len(self._drawn) + len(self._merged.parts))
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [group in groups for group in range(len(self._option.geomgroup))]
        self._option.sitegroup[:] = 0
        self._clear = False
        """Whether something in the last image is transparent, which writes no depth."""
        self._fixed = mujoco.MjvCamera()
        self._fixed.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._rgba = np.empty((height, width, 4), dtype=np.uint8)
        self._rgb = np.empty((height, width, 3), dtype=np.uint8)

    def render(
        self,
        data: mujoco.MjData,
        camera: str | mujoco.MjvCamera,
        out: Picture | None = None,
        *,
        depths: list[Array] | None = None,
        towards: Array | None = None,
    ) -> Picture:
        """Return the image of a camera, RGB, upright, shape (height, width, 3).

        Args:
            data: The state, after `mj_forward` or `mj_step`.
            camera: Name of a camera of the model, or a free one.
            out: Written and returned when given; C-contiguous, of that shape.
            depths: Gets the depth of the same pixels, as of `depth`, appended when given.
            towards: Direction of the light at the camera, world frame, shape (3,); its optical axis when None.

        Raises:
            UsageError: There is no camera of that name.
        """
        out = np.empty((*self._shape, 3), dtype=np.uint8) if out is None else self._checked(out)
        with self._canvas.at_work(self._rect.width, self._rect.height) as canvas:
            high = canvas.quality == "high" and canvas.lit is None
            self._scene.flags[:] = PICTURE_HIGH if high else PICTURE
            view = self._update(data, camera, cull=not high)
            if canvas.lit is None:
                self._light(data, view)
                if towards is not None:
                    self._turn_headlight(towards)
                mujoco.mjr_render(self._rect, self._scene, canvas.mjr)
            else:
                canvas.lit.draw(self._rect, self._scene, canvas.mjr, data)
            canvas.paint_background(general_light(self._model))
            self._read(canvas)
            # Display lists of a light map round differently, by millimetres at edges.
            shared = canvas.lit is None and not self._clear
            if depths is not None and shared:
                depths.append(self._read_depth(canvas))
        if depths is not None and not shared:
            depths.append(self.depth(data, camera))
        cv2.cvtColor(self._rgba, cv2.COLOR_RGBA2RGB, dst=out)
        return out

    def segment(self, data: mujoco.MjData, camera: str | mujoco.MjvCamera) -> NDArray[np.int32]:
        """Return the geom at each pixel's centre, -1 for none, shape (height, width)."""
        with self._canvas.at_work(self._rect.width, self._rect.height) as canvas:
            self._scene.flags[:] = INSTANCES
            with self._merged.shown_apart():
                self._update(data, camera, cull=True, ordered=False)
            mujoco.mjr_render(self._rect, self._scene, canvas.mjr)
            self._read(canvas)
        places = self._rgba.view("<u4")[..., 0] & 0xFFFFFF
        geoms = (self._scene.geoms[index].objid for index in range(self._scene.ngeom))
        return np.take(np.array([-1, *geoms], dtype=np.int32), places)

    def depth(self, data: mujoco.MjData, camera: str | mujoco.MjvCamera) -> Array:
        """Return the distance along the optical axis [m], +inf for background, shape (height, width)."""
        with self._canvas.at_work(self._rect.width, self._rect.height) as canvas:
            self._scene.flags[:] = INSTANCES  # the same depths, without the time that light and textures take
            self._update(data, camera, cull=True)
            mujoco.mjr_render(self._rect, self._scene, canvas.mjr)
            return self._read_depth(canvas)

    @property
    def drawn(self) -> int:
        """Number of geoms in the last image."""
        return int(self._scene.ngeom)

    def close(self) -> None:
        """Release the renderer; a second call does nothing."""
        if self._owns_canvas:
            self._canvas.close()

    def _read(self, canvas: Canvas) -> None:
        """Read the rendered image into `_rgba`, top row first."""
        if canvas.mjr.offSamples:
            mujoco.mjr_readPixels(self._rgb, None, self._rect, canvas.mjr)  # merges the samples of each pixel into one
            cv2.cvtColor(self._rgb, cv2.COLOR_RGB2RGBA, dst=self._rgba)
        else:
            canvas.gl.read(self._rgba)
        if canvas.mjr.offSamples or not canvas.gl.reads_from_top:
            cv2.flip(self._rgba, 0, dst=self._rgba)

    def _read_depth(self, canvas: Canvas) -> Array:
        """Return the depth of the rendered scene, as `depth` does."""
        inverse = np.empty(self._shape, dtype=np.float32)
        mujoco.mjr_readPixels(None, inverse, self._rect, canvas.mjr)
        znear, zfar = self._scene.camera[0].frustum_near, self._scene.camera[0].frustum_far
        d = inverse[::-1].astype(np.float64)
        background = d <= 0.0
        # Inverse of the projection d = n (f - z) / (z (f - n)): 1 at the near plane, 0 at the far one.
        d *= zfar - znear
        d += znear
        np.divide(znear * zfar, d, out=d)
        d[background] = np.inf
        return d

    def _turn_headlight(self, towards: Array) -> None:
        for light in self._scene.lights[: self._scene.nlight]:
            if light.headlight:
                light.dir[:] = towards

    def _checked(self, out: Picture) -> Picture:
        if out.shape != (*self._shape, 3) or out.dtype != np.uint8 or not out.flags.c_contiguous:
            raise ValueError(
                Sentence(
                    "out is {dtype} of shape {shape}; it must be C-contiguous uint8 {other_shape}, 3",
                    out.dtype,
                    out.shape,
                    self._shape,
                )
            )
        return out

    def _update(
        self, data: mujoco.MjData, camera: str | mujoco.MjvCamera, *, cull: bool, ordered: bool = True
    ) -> Frustum:
        """Fill the scene with the geoms that a camera may see, and return the view of the camera.

        Args:
            data: The state.
            camera: The camera.
            cull: Whether to leave out what it does not see.
            ordered: With `cull`, whether to sort the geoms by distance: their places are not their numbers then.
        """
        model, scene = self._model, self._scene
        mujoco.mjv_updateCamera(model, data, self._camera(camera), scene)
        view = frustum_of(scene, width=self._rect.width, height=self._rect.height)
        in_view = self._in_view if self._apart is None or self._merged.intact else self._apart
        unseen = in_view.unseen(data, view) if cull else self._drawn[:0]
        self._clear = len(np.setdiff1d(in_view.clear, unseen)) > 0
        groups = model.geom_group[unseen]
        model.geom_group[unseen] = UNSEEN
        try:
            scene.ngeom = 0
            mujoco.mjv_addGeoms(model, data, self._option, mujoco.MjvPerturb(), CATEGORIES, scene)
        finally:
            model.geom_group[unseen] = groups
        if cull and ordered:
            in_view.sort(scene, view)
        return view

    def _light(self, data: mujoco.MjData, view: Frustum) -> None:
        """Give the scene the lights that matter in a view."""
        model, scene = self._model, self._scene
        if not len(self._lamps):
            mujoco.mjv_makeLights(model, data, scene)
            return
        burning = model.light_active.copy()
        model.light_active[self._lamps_unseen(data, view)] = 0
        try:
            mujoco.mjv_makeLights(model, data, scene)
        finally:
            model.light_active[:] = burning

    def _camera(self, camera: str | mujoco.MjvCamera) -> mujoco.MjvCamera:
        if not isinstance(camera, str):
            return camera
        found = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_CAMERA, camera)
        if found < 0:
            names = [self._model.camera(index).name for index in range(self._model.ncam)]
            raise UsageError(
                Sentence("no camera '{camera}' in this scene{did_you_mean}", camera, did_you_mean(camera, names))
            )
        self._fixed.fixedcamid = found
        return self._fixed

    def _lamps_unseen(self, data: mujoco.MjData, view: Frustum) -> NDArray[np.intp]:
        """Return the lamps that light nothing in this view, and those above the limit, farthest first."""
        model, lamps = self._model, self._lamps
        reach = np.where(model.light_active[lamps], model.light_range[lamps], -np.inf)
        offsets = data.light_xpos[lamps] - view.eye
        seen = ~view.beside(offsets, reach)
        order = np.lexsort([np.linalg.norm(offsets, axis=1), ~seen])
        room = min(int(seen.sum()), lamps_drawn(model))
        return np.asarray(lamps[order[room:]])

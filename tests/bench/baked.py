"""The cost of baked light: pictures of one scene in both kinds of light, in turn."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import numpy as np

from mjsim.bench.figure import Clock, Once, Prepare
from mjsim.bench.rooms import place
from mjsim.bench.scenes import gallery, gallery_places
from mjsim.sim import Canvas, Quality, Renderer, StillScene
from mjsim.world import World

WIDTH, HEIGHT, PLACES = 640, 480, 40
"""Size of pictures [px], and places on the tour through the gallery."""


def baked_against(plain: Quality, *, baked: Quality = "normal", make: Callable[[], World] = gallery) -> Prepare:
    """Measure how many times as long a baked picture takes as a plain one.

    Args:
        plain: Quality of plain pictures.
        baked: The same of baked ones.
        make: Returns the gallery.
    """

    @contextmanager
    def prepare() -> Iterator[Once]:
        scene = StillScene(make().model_copy(update={"shading": "baked"}))
        with ExitStack() as stack:
            canvases = Canvas(scene.model, quality=plain), Canvas(scene.model, quality=baked, light=scene.light)
            for canvas in canvases:
                stack.callback(canvas.close)
            pair = [Renderer(scene.model, width=WIDTH, height=HEIGHT, canvas=canvas) for canvas in canvases]

            def once(clock: Clock) -> float:
                seconds = [0.0, 0.0]
                for pose in gallery_places(PLACES):
                    place(scene.model, scene.data, "scout", np.array([pose.x, pose.y, pose.heading]))
                    for kind, renderer in enumerate(pair):
                        began = clock()
                        renderer.render(scene.data, "scout/front")
                        seconds[kind] += clock() - began
                return seconds[1] / seconds[0]

            scene.show(scene.model.qpos0)
            for renderer in pair:  # The first picture copies all that is drawn.
                renderer.render(scene.data, "scout/front")
            yield once

    return prepare


def textured_gallery() -> World:
    """Return the gallery with textures on all walls."""
    world = gallery()
    plaster = {"texture": "materials/plaster.jpg", "tile": 2.0}
    return world.model_copy(update={"walls": tuple(wall.model_copy(update=plaster) for wall in world.walls)})

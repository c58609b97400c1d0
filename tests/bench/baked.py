"""The cost of baked light: pictures of one scene in both kinds of light, in turn."""

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import numpy as np

from mjsim.bench.figure import Clock, Once, Prepare
from mjsim.bench.rooms import place
from mjsim.bench.scenes import gallery, gallery_places
from mjsim.geometry import Pose
from mjsim.sim import Canvas, Quality, Renderer, StillScene
from mjsim.world import World, load_world

WIDTH, HEIGHT, PLACES = 640, 480, 40
"""Size of pictures [px], and places on the tour through the gallery."""
OFFICE_PLACES = (
    *(Pose(2.0 + 1.6 * k, 6.2, 0.4 * math.sin(k)) for k in range(20)),
    *(Pose(1.6 + 3.6 * k, 3.2, -1.2) for k in range(10)),
    *(Pose(1.6 + 3.6 * k, 9.2, 1.2) for k in range(10)),
)
"""Along the corridor of the office, and in its rooms, towards the desks."""


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


@contextmanager
def furnished() -> Iterator[Once]:
    """Measure how many times as long a picture of the furnished office takes as one of the textured gallery."""
    office = load_world("office", settings={"shading": "plain"})
    worlds = (office, "post", OFFICE_PLACES), (textured_gallery(), "scout", gallery_places(len(OFFICE_PLACES)))
    with ExitStack() as stack:
        shown = []
        for world, robot, places in worlds:
            scene = StillScene(world)
            scene.show(scene.model.qpos0)
            renderer = stack.enter_context(Renderer(scene.model, width=WIDTH, height=HEIGHT))
            renderer.render(scene.data, f"{robot}/front")  # The first picture copies all that is drawn.
            shown.append((scene, renderer, robot, places))

        def once(clock: Clock) -> float:
            seconds = [0.0, 0.0]
            for k in range(len(OFFICE_PLACES)):
                for kind, (scene, renderer, robot, places) in enumerate(shown):
                    pose = places[k]
                    place(scene.model, scene.data, robot, np.array([pose.x, pose.y, pose.heading]))
                    began = clock()
                    renderer.render(scene.data, f"{robot}/front")
                    seconds[kind] += clock() - began
            return seconds[0] / seconds[1]

        yield once


def textured_gallery() -> World:
    """Return the gallery with textures on all walls."""
    world = gallery()
    plaster = {"texture": "materials/plaster.jpg", "tile": 2.0}
    return world.model_copy(update={"walls": tuple(wall.model_copy(update=plaster) for wall in world.walls)})

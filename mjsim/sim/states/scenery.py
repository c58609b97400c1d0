"""Appearance of a compiled world after events: light, lamps, and removed objects."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import GHOST, dim_lamp, dim_light, lamp_names
from mjsim.sim.rendering import UNSEEN, Merged
from mjsim.world import (
    Looks,
    ReachEvent,
    RemoveEvent,
    RestoreEvent,
    World,
    WorldEvent,
    first_looks,
    item_names,
)

if TYPE_CHECKING:
    from mjsim.sim.person_hands import LedHands

FREE_BODY_DOFS = 6
"""Degrees of freedom of a free body."""


class Scenery:
    """Sets a model to the looks of an instant, forwards or backwards in time; changes the model in place."""

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        """Store the compiled model, so that removed objects can be restored."""
        self._model, self._world = model, world
        self._looks = first_looks(world)
        self._lamps = dict(zip(item_names(world.lamps), zip(world.lamps, lamp_names(world), strict=True), strict=True))
        self._hands = _hands_of(model, world)
        self._merged = Merged(model)
        self._contacts = np.stack([model.geom_contype, model.geom_conaffinity])

    @property
    def looks(self) -> Looks:
        """Current looks."""
        return self._looks

    def show(self, looks: Looks) -> None:
        """Set the model to given looks."""
        before, self._looks = self._looks, looks
        if looks.light != before.light:
            dim_light(self._model, looks.light)
        for name, brightness in looks.lamps.items():
            if brightness != before.lamps[name]:
                lamp, light = self._lamps[name]
                dim_lamp(self._model, light, lamp, brightness)
        if self._hands is not None and (looks.reached or before.reached):
            self._hands.show(looks.reached, looks.time)
            if any(turns[-1].motion is None for turns in looks.reached.values()):
                self._looks = replace(looks, reached=self._hands.people.computed(looks.reached))
        for name in sorted(looks.removed - before.removed):
            self._take_away(name)
        for name in sorted(before.removed - looks.removed):
            self._bring_back(name)

    def tried(self, event: ReachEvent, before: Sequence[WorldEvent] = ()) -> ReachEvent:
        """Return the event of a hand after others, with the remaining distance of the hand from its goal."""
        assert self._hands is not None, "only people have hands"
        looks = self._looks
        for each in (*before, event):
            looks = looks.after(each, self._world)
        return event.stays_away(self._hands.people.short(event.reach, looks.reached[event.reach]))

    def _take_away(self, name: str) -> None:
        """Hide an object from cameras, rays and contacts; a free body stays on the floor."""
        model, geoms = self._model, self.geoms(name)
        self._merged.take_out(geoms)
        model.geom_group[geoms] = UNSEEN
        solid = geoms[(model.geom_contype[geoms] | model.geom_conaffinity[geoms]) != 0]
        model.geom_contype[solid] = model.geom_conaffinity[solid] = 0
        bodies = model.geom_bodyid[solid]
        falls = model.body_dofnum[model.body_rootid[bodies]] == FREE_BODY_DOFS
        model.geom_contype[solid[falls]] = GHOST
        # MuJoCo also tests whole bodies for possible contact.
        model.body_contype[bodies[falls]] |= GHOST
        model.geom_conaffinity[model.geom("floor").id] |= GHOST
        model.body_conaffinity[0] |= GHOST

    def removed_after(self, events: Iterable[WorldEvent]) -> frozenset[str]:
        """Return the names of the objects that are removed after some events."""
        looks = self._looks
        for each in events:
            if isinstance(each, RemoveEvent | RestoreEvent):
                looks = looks.after(each, self._world)
        return looks.removed

    @contextmanager
    def without(self, removed: Collection[str]) -> Iterator[None]:
        """Remove these objects in the block, and no others, for a trial."""
        before = self._looks
        self.show(replace(before, removed=frozenset(removed)))
        try:
            yield
        finally:
            self.show(before)

    def _bring_back(self, name: str) -> None:
        geoms = self.geoms(name)
        self._model.geom_group[geoms] = self._merged.groups_apart[geoms]
        self._model.geom_contype[geoms], self._model.geom_conaffinity[geoms] = self._contacts[:, geoms]

    def geoms(self, name: str) -> NDArray[np.intp]:
        """Return the geoms of an obstacle or a beacon in the compiled world, and those of the beacons on it."""
        model = self._model
        names = [model.geom(index).name for index in range(model.ngeom)]
        own = (f"obstacle/{name}", f"beacon/{name}")
        parts = tuple(f"{each}{mark}" for each in own for mark in "/:")
        mine = np.array([each in own or each.startswith(parts) for each in names])
        for kind in own:
            index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, kind)
            if index > 0:
                mine |= model.body_rootid[model.geom_bodyid] == index
        return np.flatnonzero(mine)


def _hands_of(model: mujoco.MjModel, world: World) -> "LedHands | None":
    """Return the object that moves people's hands; without people, no code for them is loaded."""
    if not world.people:
        return None
    from mjsim.sim.person_hands import LedHands

    return LedHands(model, world)

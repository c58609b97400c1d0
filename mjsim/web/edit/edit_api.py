"""Requests of the page while a world is edited."""

import math
from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from mjsim.errors import UsageError, WorldError
from mjsim.geometry import Pose
from mjsim.record import named_files
from mjsim.sentences import Sentence
from mjsim.web.edit.panel_schema import schema_text
from mjsim.web.edit.portraits import Portraits, text_of
from mjsim.web.edit.poses import PoseAsk, pose_json
from mjsim.web.edit.preview import Preview, PreviewRequest
from mjsim.web.run import Drivers, Scene3dShelf, with_drivers
from mjsim.web.server import HEADERS, Ask, RefusedError, answer_get, answered, body_of, packed_response, posted, refusal
from mjsim.web.worlds import (
    MAX_BYTES,
    Folder,
    Json,
    Parsed,
    Read,
    Signs,
    Trust,
    bring_picture,
    judged_pictures,
    listed,
    modules_in,
    new_world,
    parsed,
    preset_of,
    read_world,
    save_world,
    signs_of,
    small_picture,
    source_of,
    source_of_use,
)
from mjsim.web.worlds import MAX_FILES as MAX_WATCHED
from mjsim.world import Change, UnwritableError, World, edited, items_in, parse_world

CACHE_SIZE = 3
"""Number of parsed texts that are kept: an undo needs the previous one again."""
MAX_JUDGED = 200
"""Maximum number of pictures that are judged at once."""


class OpenAsk(Ask):
    """Opens a world."""

    path: str


class NewAsk(Ask):
    """Creates a world: its name, and its template."""

    path: str | None = None
    template: str | None = None


class RobotAsk(Ask):
    """Makes a preset of a robot's file, relative to the folder of a world."""

    file: str
    path: str | None = None


class TextAsk(Ask):
    """A text and its path."""

    path: str
    text: str


Step = Annotated[str, Field(max_length=400)] | int
"""A key or an index; no world has longer keys."""


class ChangeAsk(Ask):
    """One change of a world."""

    op: Literal["set", "unset", "add", "remove", "rename", "single", "apart"]
    path: Annotated[tuple[Step, ...], Field(max_length=50)]
    """No values are nested deeper."""
    value: Any = None


class TrustAsk(TextAsk):
    """Allows the code of a text, with the code that the user was shown."""

    code: dict[str, str]
    drivers: Annotated[Drivers, Field(default_factory=dict)]


class SourceAsk(TextAsk):
    """Asks for the source of a module named by a text."""

    use: str


class JudgeAsk(TextAsk):
    """Asks how well pictures that may be added to a world can be recognised."""

    images: Annotated[list[str], Field(max_length=MAX_JUDGED)]


class EditAsk(TextAsk):
    """Changes to apply to a text."""

    changes: list[ChangeAsk]


class PasteAsk(Ask):
    """A text that may contain items."""

    text: str


class SaveAsk(TextAsk):
    """Saves a text over the version that it is based on."""

    stamp: str | None = None
    overwrite: bool = False


class PreviewAsk(TextAsk):
    """Asks for a camera's picture from the position to which its robot is being moved."""

    robot: str
    camera: str
    at: tuple[float, float]
    heading_deg: float = 0.0
    width: int = 320


def _schema(request: Request) -> Response:
    return packed_response(request, schema_text(), "application/json")


class EditApi:
    """Opens, reads, changes and saves the worlds of a folder."""

    def __init__(self, folder: Folder, trust: Trust, *, world: str | None, saved: Callable[[], None]) -> None:
        """Store the folder and the code that may run.

        Args:
            folder: Folder of the studio.
            trust: The code that may run.
            world: World to open first.
            saved: Called after a file was written.
        """
        self._folder, self._trust, self._world, self._saved = folder, trust, world, saved
        self._preview, self._solids, self._portraits = Preview(), Scene3dShelf(), Portraits()
        self._seen: tuple[tuple[str, str], World, Signs] | None = None
        self._cached: tuple[tuple[tuple[str, str], Parsed, Signs], ...] = ()
        self.routes: Sequence[BaseRoute] = [
            Route("/api/folder", answer_get(self._list), methods=["GET"]),
            Route("/api/schema", answer_get(_schema), methods=["GET"]),
            Route("/api/modules", answer_get(self._modules), methods=["GET"]),
            Route("/api/open", posted(OpenAsk, self._open), methods=["POST"]),
            Route("/api/new", posted(NewAsk, self._new), methods=["POST"]),
            Route("/api/robot", posted(RobotAsk, self._robot), methods=["POST"]),
            Route("/api/parse", posted(TextAsk, self._parse), methods=["POST"]),
            Route("/api/edit", posted(EditAsk, self._edit), methods=["POST"]),
            Route("/api/items", posted(PasteAsk, self._items), methods=["POST"]),
            Route("/api/save", posted(SaveAsk, self._save), methods=["POST"]),
            Route("/api/source", posted(SourceAsk, self._source), methods=["POST"]),
            Route("/api/judge", posted(JudgeAsk, self._judge), methods=["POST"]),
            Route("/api/trust", posted(TrustAsk, self._allow), methods=["POST"]),
            Route("/api/preview", posted(PreviewAsk, self._see), methods=["POST"]),
            Route("/api/pose", posted(PoseAsk, self._pose), methods=["POST"]),
            Route("/api/scene", posted(TextAsk, self._scene), methods=["POST"]),
            Route("/api/upload", self._upload, methods=["POST"]),
            Route("/api/picture", answer_get(self._picture), methods=["GET"]),
            Route("/api/portrait", answer_get(self._portrait), methods=["GET"]),
        ]

    def close(self) -> None:
        """Release the renderers of previews."""
        self._preview.close()

    def world_of(self, path: str, text: str) -> World:
        """Return the world of a text.

        Raises:
            RefusedError: The text is invalid, or the path is outside the folder.
        """
        try:
            return parse_world(text, source=self._trust.guarded(source_of(self._folder, path)))
        except WorldError as error:
            first, more = error.problems[0], len(error.problems) - 1
            others = Sentence(" (and {more} more)", more) if more else ""
            raise RefusedError(
                409, Sentence("line {line}: {message}{others}", first.line, first.message, others)
            ) from None

    def _list(self, _: Request) -> Json:
        return {**listed(self._folder), "world": self._world, "mode": "studio"}

    def _modules(self, request: Request) -> Json:
        return modules_in(self._folder, request.query_params.get("path"))

    def _open(self, ask: OpenAsk) -> Json:
        text, stamp = read_world(self._folder, ask.path)
        return {"path": ask.path, "text": text, "stamp": stamp, **self._parsed_json(ask.path, text)}

    def _new(self, ask: NewAsk) -> Json:
        path, text = new_world(self._folder, ask.path, template=ask.template)
        return {"path": path, "text": text, "stamp": None, **self._parsed_json(path, text)}

    def _robot(self, ask: RobotAsk) -> Json:
        return preset_of(self._folder, ask.file, world=ask.path)

    def _parse(self, ask: TextAsk) -> Json:
        return self._parsed_json(ask.path, ask.text)

    def _edit(self, ask: EditAsk) -> Json:
        changes = [Change(change.op, change.path, change.value) for change in ask.changes]
        try:
            text, node = edited(ask.text, changes, source=source_of(self._folder, ask.path))
        except UnwritableError as error:
            raise RefusedError(409, str(error), path=list(error.path)) from None
        return {"text": text, **self._parsed_json(ask.path, text, read=(node, []))}

    def _items(self, ask: PasteAsk) -> Json:
        try:
            return {"items": [{"list": name, "value": value} for name, value in items_in(ask.text)]}
        except UsageError as error:
            raise RefusedError(409, str(error)) from None

    def _save(self, ask: SaveAsk) -> Json:
        stamp = save_world(self._folder, ask.path, text=ask.text, stamp=ask.stamp, overwrite=ask.overwrite)
        self._saved()
        return {"stamp": stamp}

    def _source(self, ask: SourceAsk) -> Json:
        return source_of_use(self.world_of(ask.path, ask.text), ask.use)

    def _judge(self, ask: JudgeAsk) -> Json:
        return {"pictures": judged_pictures(self.world_of(ask.path, ask.text), ask.images)}

    def _allow(self, ask: TrustAsk) -> Json:
        world = with_drivers(self.world_of(ask.path, ask.text), ask.drivers)
        self._trust.allow(world, ask.code)
        return {"needs_trust": self._trust.asks_for(world)}

    def _see(self, ask: PreviewAsk) -> Response:
        world, signs = self._seen_world(ask.path, ask.text)
        # A user-defined drive is code, too.
        self._trust.check(world)
        pose = Pose(ask.at[0], ask.at[1], math.radians(ask.heading_deg))
        request = PreviewRequest(world, ask.robot, ask.camera, pose, ask.width, signs)
        data, taken = self._preview.picture(request)
        return Response(data, media_type="image/jpeg", headers={**HEADERS, "Server-Timing": f"draw;dur={taken:.1f}"})

    def _pose(self, ask: PoseAsk) -> Json:
        return pose_json(self._seen_world(ask.path, ask.text)[0], ask)

    def _scene(self, ask: TextAsk) -> Response:
        """Return the response with the 3-D scene of a text."""
        world, _ = self._seen_world(ask.path, ask.text)
        self._trust.check(world)
        return self._solids.of(world).surfaces()

    def _seen_world(self, path: str, text: str) -> tuple[World, Signs]:
        """Return the world of a text, without modules that drive, and the signs of its files.

        Both stay the same while something is dragged.
        """
        last = self._seen
        if last is None or last[0] != (path, text) or last[2] != signs_of(self._folder, path, last[2]):
            world = _undriven(self.world_of(path, text))
            self._seen = last = (path, text), world, signs_of(self._folder, path, named_files(world))
        return last[1], last[2]

    async def _upload(self, request: Request) -> Response:
        name, world = request.query_params.get("name", "picture"), request.query_params.get("path")
        try:
            async with body_of(request, limit=MAX_BYTES) as data:
                return await answered(lambda: bring_picture(self._folder, data, name=name, world=world))
        except RefusedError as refused:
            return refusal(refused)

    def _picture(self, request: Request) -> Response:
        given = request.query_params
        size = given.get("size", "256")
        if not size.isdecimal() or len(size) > 6:
            raise RefusedError(400, Sentence("size is {size:.20}; it must be a number of pixels", size))
        data = small_picture(self._folder, given.get("path", ""), size=int(size), world=given.get("world"))
        return Response(data, media_type="image/jpeg", headers={**HEADERS, "Cache-Control": "private, max-age=60"})

    def _portrait(self, request: Request) -> Response:
        """Return the response with a picture of a single model, robot or arm."""
        given = request.query_params
        path, name = given.get("world", ""), given.get("name", "")
        text = text_of(given.get("kind", ""), name)

        def world() -> World:
            found = self.world_of(path, text)
            self._trust.check(found)
            return found

        folder = str(source_of(self._folder, path).folder)
        signs = signs_of(self._folder, path, [name, f"{name}.yaml"])
        data = self._portraits.picture(text, folder=folder, signs=signs, world=world)
        return Response(data, media_type="image/jpeg", headers={**HEADERS, "Cache-Control": "private, max-age=60"})

    def _parsed_json(self, path: str, text: str, *, read: Read | None = None) -> Json:
        found, files = self._known(path, text) or self._newly_parsed(path, text, read)
        needs = [] if found.world is None else self._trust.asks_for(found.world)
        return {**found.content, "needs_trust": needs, "files": files}

    def _known(self, path: str, text: str) -> tuple[Parsed, Signs] | None:
        """Return a recently parsed text, as for an undo, if its files are unchanged; otherwise None."""
        for key, found, files in self._cached:
            if key == (path, text) and files == signs_of(self._folder, path, files):
                return found, files
        return None

    def _newly_parsed(self, path: str, text: str, read: Read | None) -> tuple[Parsed, Signs]:
        found = parsed(text, source_of(self._folder, path), read=read)
        files = signs_of(self._folder, path, found.content["files"])
        # An error may be fixed without a change of any file, for example by installing a module.
        if not found.content["problems"] and len(files) < MAX_WATCHED:
            others = [each for each in self._cached if each[0] != (path, text)]
            self._cached = ((path, text), found, files), *others[: CACHE_SIZE - 1]
        return found, files


def _undriven(world: World) -> World:
    """Return a world without the modules that drive its robots, so that viewing it needs no permission."""
    return world.model_copy(update={"run": world.run.model_copy(update={"drivers": {}})})

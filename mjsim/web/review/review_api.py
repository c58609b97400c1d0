"""Requests of the page for recordings: overview, single ticks, pictures, numbers, and films of a section."""

import math
import re
import secrets
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path, PurePosixPath
from typing import Annotated, Any

from pydantic import Field
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, Response
from starlette.routing import BaseRoute, Route

from mjsim.errors import MjsimError
from mjsim.output import free_path, move_to_free
from mjsim.record import read_recording
from mjsim.report import statistics_file
from mjsim.sentences import Sentence
from mjsim.sim import Orbit
from mjsim.web.review.comparing import compared, compared_json, first_recording, first_swept_world
from mjsim.web.review.fields import column_json, fields_json, message_json
from mjsim.web.review.films import Films
from mjsim.web.review.open_recordings import Opened, Shelf
from mjsim.web.review.recordings_list import Recorded, plan_of
from mjsim.web.review.reviewing import WHOLE, default_film, recording_json, row_at, row_json
from mjsim.web.run import Scene, TickNews
from mjsim.web.server import HEADERS, Ask, RefusedError, answer_get, answered, posted, refusal
from mjsim.web.worlds import Folder

MAX_UPLOAD_BYTES = 4_000_000_000
"""Maximum size of an uploaded recording [bytes]."""
BROUGHT = "out/brought"
"""Folder of uploaded recordings."""
_ODD = re.compile(r"[^A-Za-z0-9_.-]+")


class FilmAsk(Ask):
    """The section of a recording to film, and the view."""

    path: str
    begin: Annotated[float, Field(alias="from")]
    end: Annotated[float, Field(alias="to")]
    view: str = WHOLE


class ReviewApi:
    """Opens the recordings of a folder."""

    def __init__(self, folder: Folder, *, scene: Scene) -> None:
        """Store the folder, and the function that returns the plan of a world."""
        self._folder, self._scene = folder, scene
        self._shelf, self._films, self._recorded = Shelf(), Films(), Recorded(folder)
        self.routes: Sequence[BaseRoute] = [
            Route("/api/recordings", answer_get(lambda _: self._recorded.cards()), methods=["GET"]),
            Route("/api/recording", answer_get(self._whole), methods=["GET"]),
            Route("/api/recording/plan", answer_get(self._plan), methods=["GET"]),
            Route("/api/recording/tick", answer_get(self._tick), methods=["GET"]),
            Route("/api/recording/picture", answer_get(self._picture), methods=["GET"]),
            Route("/api/recording/scene", answer_get(self._scene_in_3d), methods=["GET"]),
            Route("/api/recording/poses", answer_get(self._poses), methods=["GET"]),
            Route("/api/recording/fields", answer_get(self._fields), methods=["GET"]),
            Route("/api/recording/message", answer_get(self._message), methods=["GET"]),
            Route("/api/recording/column", answer_get(self._column), methods=["GET"]),
            Route("/api/recording/statistics", answer_get(self._statistics), methods=["GET"]),
            Route("/api/recording/video", posted(FilmAsk, self._film), methods=["POST"]),
            Route("/api/recording/upload", self._upload, methods=["POST"]),
            Route("/api/compare", answer_get(self._compare), methods=["GET"]),
            Route("/api/job", answer_get(self._job), methods=["GET"]),
            Route("/api/file", answer_get(self._file), methods=["GET"]),
        ]

    def close(self) -> None:
        """Release everything."""
        self._films.close()
        self._shelf.close()

    def _whole(self, request: Request) -> dict[str, Any]:
        path, opened = self._opened(request)
        return recording_json(opened.recording, path=path, scene=self._scene(opened.recording.world))

    def _plan(self, request: Request) -> Response:
        """Return the response with a small plan of a recording's world."""
        path = self._folder.path(request.query_params.get("path", ""))
        data = plan_of(path, "dark" if request.query_params.get("theme") == "dark" else "light")
        return Response(data, media_type="image/svg+xml", headers={**HEADERS, "Cache-Control": "private, max-age=60"})

    def _tick(self, request: Request) -> TickNews:
        _, opened = self._opened(request)
        row = row_at(opened.recording, _number(request, "time"))
        return row_json(opened.recording, row, measured=opened.measured, people=opened.people(row))

    def _picture(self, request: Request) -> Response:
        _, opened = self._opened(request)
        orbit = None
        if "distance" in request.query_params:
            orbit = Orbit(
                azimuth=math.radians(_number(request, "azimuth_deg", limit=1e6)),
                elevation=math.radians(_number(request, "elevation_deg", limit=90.0)),
                distance=max(_number(request, "distance", limit=1000.0), 0.1),
                at=(_number(request, "x", limit=1e6), _number(request, "y", limit=1e6)),
            )
        data = opened.picture(_number(request, "time"), request.query_params.get("view", "overview"), orbit=orbit)
        return Response(data, media_type="image/jpeg", headers=HEADERS)

    def _scene_in_3d(self, request: Request) -> Response:
        """Return the response with the 3-D scene of a recording."""
        return self._opened(request)[1].solids().surfaces()

    def _poses(self, request: Request) -> Response:
        """Return the response with the poses of a recording's bodies at a time."""
        data = self._opened(request)[1].poses(_number(request, "time"))
        return Response(data, media_type="application/octet-stream", headers=HEADERS)

    def _message(self, request: Request) -> dict[str, Any] | None:
        topic = request.query_params.get("topic", "")
        return message_json(self._opened(request)[1].recording, topic, _number(request, "time"))

    def _fields(self, request: Request) -> dict[str, Any]:
        return fields_json(self._opened(request)[1].recording)

    def _column(self, request: Request) -> dict[str, list[float | None]]:
        topic, field = (request.query_params.get(name, "") for name in ("topic", "field"))
        return column_json(self._opened(request)[1].recording, topic, field)

    def _statistics(self, request: Request) -> dict[str, Any]:
        _, opened = self._opened(request)
        begin, end = (_number(request, name) if name in request.query_params else None for name in ("from", "to"))
        return statistics_file(opened.recording.between(begin, end))

    def _compare(self, request: Request) -> dict[str, Any]:
        names = request.query_params.getlist("path")
        comparison = compared(self._folder, names)
        first = first_recording(self._folder, names)
        world = first_swept_world(self._folder, names) if first is None else self._shelf.open(first).recording.world
        scene = None if world is None else self._scene(world)
        return compared_json(comparison, scene=scene)

    def _film(self, ask: FilmAsk) -> dict[str, Any]:
        recording = self._shelf.open(self._folder.path(ask.path)).recording
        film = default_film(ask.path, view=ask.view, begin=ask.begin, end=ask.end)
        place = free_path(self._folder.path(film.as_posix()), taken=self._films.files())
        view = None if ask.view == WHOLE else ask.view
        shown = self._folder.name(place)
        job = self._films.begin(recording, place, shown=shown, view=view, begin=ask.begin, end=ask.end)
        return {"job": job}

    def _job(self, request: Request) -> dict[str, Any]:
        return asdict(self._films.progress(request.query_params.get("id", "")))

    def _file(self, request: Request) -> Response:
        """Return a file that was made here, for download."""
        name = request.query_params.get("path", "")
        place = self._folder.path(name)
        if PurePosixPath(name).parts[:1] != ("out",) or not place.is_relative_to(self._folder.path("out")):
            raise RefusedError(403, Sentence("'{name:.80}' is not in 'out'; only files in it can be downloaded", name))
        if not place.is_file():
            raise RefusedError(404, Sentence("no file '{name:.80}'; it may have been moved or removed", name))
        return FileResponse(place, filename=place.name, headers=HEADERS)

    async def _upload(self, request: Request) -> Response:
        """Receive an uploaded recording, and keep it if it is valid."""
        part = self._folder.root / BROUGHT / f".{secrets.token_hex(8)}.part"
        try:
            await self._receive(request, part)
            return await answered(lambda: self._keep(part, request.query_params.get("name", "")))
        except RefusedError as refused:
            return refusal(refused)
        finally:
            part.unlink(missing_ok=True)

    async def _receive(self, request: Request, part: Path) -> None:
        size = 0
        try:
            self._folder.path(BROUGHT).mkdir(parents=True, exist_ok=True)
            with part.open("xb") as file:
                async for chunk in request.stream():
                    size += len(chunk)
                    if size > MAX_UPLOAD_BYTES:
                        raise RefusedError(
                            413,
                            Sentence(
                                "this is larger than {limit:.0f} GB; copy it into the folder",
                                MAX_UPLOAD_BYTES / 1e9,
                            ),
                        )
                    await run_in_threadpool(file.write, chunk)
        except ClientDisconnect:
            raise RefusedError(400, "the recording arrived incomplete; send it again") from None
        except OSError as error:
            raise RefusedError(409, Sentence("the recording cannot be kept: {strerror}", error.strerror)) from None

    def _keep(self, part: Path, name: str) -> dict[str, Any]:
        """Move an uploaded recording to its final name."""
        try:
            read_recording(part)
        except MjsimError as error:
            why = str(error).partition("\n")[0].replace(str(part), name[:80])
            raise RefusedError(400, Sentence("this cannot be opened: {why}", why)) from None
        stem = _ODD.sub("-", PurePosixPath(name.replace("\\", "/")).stem).strip("-.") or "run"
        return {"path": self._folder.name(move_to_free(part, part.parent / f"{stem[:60]}.mcap"))}

    def _opened(self, request: Request) -> tuple[str, Opened]:
        path = request.query_params.get("path", "")
        return path, self._shelf.open(self._folder.path(path))


def _number(request: Request, name: str, *, limit: float = math.inf) -> float:
    """Return a number in a request's address."""
    text = request.query_params.get(name, "")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RefusedError(400, Sentence("{name} is {text!r:.40}; it must be a number", name, text))
    if abs(value) > limit:
        raise RefusedError(
            400, Sentence("{name} is {value:g}; it must be from {low:g} to {high:g}", name, value, -limit, limit)
        )
    return value

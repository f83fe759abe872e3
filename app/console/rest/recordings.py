"""Recordings: making them, listing, downloading, deleting, replaying."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from fastapi import APIRouter, Header, Path, Request
from fastapi.responses import Response

from app.attention.desires import Desire
from app.base.named_library import NAME
from app.console.access.identity import identity_of
from app.console.access.roles import Role
from app.console.problems import Problem
from app.console.recordings import RecorderWatch, record, withdraw
from app.console.records.recordings import RecordingList, RecordingReport, ReplayReport, Saved, Withdrawn
from app.console.replays import ReplayFailed, ReplayReplaced, Replays, reached_by
from app.console.rest.answers import BYTES, Json, problems
from app.console.rest.desires import DESIRE_LINKS, OPERATOR_PARAMETER, refuse_too_many, source_of
from app.console.rest.download import MCAP, Download
from app.console.rest.idempotency import KEY_LIMITS, IdempotencyStore
from app.console.rest.recording_models import NewRecording, SaveRequest
from app.console.rest.routing import router as api_router
from app.logs.catalog import Catalog, Recording
from app.logs.log import LogError
from app.logs.recorder_service import RecorderUnavailable

if TYPE_CHECKING:
    from app.program.system import System

T = TypeVar("T")
Name = Annotated[
    str,
    Path(description="The recording's name.", examples=["tour"], json_schema_extra={"pattern": f"^{NAME.pattern}$"}),
]


def recordings_router(system: System, replays: Replays, played: FilePath | None = None) -> APIRouter:
    """Routes of ``/recordings``; ``played`` is the file of the recording that this console is a replay of."""
    router = api_router("recordings")
    catalog = Catalog(system.recordings)
    report = RecorderWatch(system)
    store = IdempotencyStore(system.clock.now)

    @router.get("/recordings", response_model=RecordingList, summary="List all recordings")
    async def list_recordings(request: Request) -> Response:
        """The newest first, with the room left on the disk and what the Recorder does."""
        found = await _on_disk(catalog.recordings)
        free = await _on_disk(system.recordings.free_bytes)
        return Json(
            RecordingList(
                folder=str(system.recordings.folder),
                free_bytes=free,
                recorder=report.report(),
                replay=_replay(replays, request),
                recordings=tuple(_recording(each, report) for each in found),
            )
        )

    @router.post(
        "/recordings",
        response_model=Desire,
        status_code=201,
        summary="Start recording",
        openapi_extra=OPERATOR_PARAMETER,
        responses={
            201: {
                "headers": {"Location": {"schema": {"type": "string"}, "description": "Where the desire is."}},
                "links": DESIRE_LINKS,
            },
            **problems(400, 409, 422),
        },
    )
    async def start_recording(
        request: Request,
        new: NewRecording | None = None,
        idempotency_key: Annotated[
            str | None,
            Header(
                description="As of POST /desires: a repeated request with the same key is done once.",
                json_schema_extra=KEY_LIMITS,
            ),
        ] = None,
    ) -> Response:
        """Creates a desire of class Record; attention weighs it as any other. Whether it records, and if not why, is in
        `recorder` of the list and on the live stream. Needs no body.

        Refused while a recording runs that was asked for here; a ring gives way, and what it held is kept as a
        recording of its own."""
        new = new or NewRecording()
        body = new.model_dump()
        if known := store.find(idempotency_key, body):
            headers = {"Location": known.location, "Idempotency-Replayed": "true"}
            return Json(known.body, status_code=201, headers=headers)
        _need_recorder(report)
        await _need_free(new.name)
        if (running := report.in_progress()) is not None:
            raise Problem(
                409,
                "recording-in-progress",
                f"A recording{running and f' ({running})'} is in progress, and would end: stop it first, with POST "
                "/api/v1/recordings/stop.",
            )
        refuse_too_many(system)
        desire = record(
            system,
            source_of(request),
            name=new.name,
            keep_minutes=new.keep_minutes,
            intensity=new.intensity,
            utility=new.utility,
        )
        location = f"/api/v1/desires/{desire.id}"
        store.remember(idempotency_key, body, location, desire)
        return Json(desire, status_code=201, headers={"Location": location})

    @router.post("/recordings/stop", response_model=Withdrawn, summary="Stop recording")
    async def stop_recording() -> Response:
        """Withdraws every desire of class Record that came over the console. Needs no body. May be repeated."""
        ours, remaining = withdraw(system)
        return Json(Withdrawn(tuple(desire.id for desire in ours), tuple(remaining)))

    @router.post(
        "/recordings/save",
        response_model=Saved,
        status_code=201,
        summary="Keep the ring's last minutes",
        responses={
            201: {"headers": {"Location": {"schema": {"type": "string"}, "description": "Where the recording is."}}},
            **problems(400, 409, 422, 507),
        },
    )
    async def save_ring(save: SaveRequest | None = None) -> Response:
        """Makes a recording of what the ring holds; the ring goes on. Needs no body."""
        save = save or SaveRequest()
        _need_recorder(report)
        await _need_free(save.name)
        try:
            name = await system.recorder.save_ring(save.minutes, save.name or None)
        except RecorderUnavailable as refusal:
            raise Problem(409, "no-ring", f"Nothing can be saved: {refusal}.") from None
        except LogError as failure:
            raise Problem(507, "recording-not-saved", f"The ring was not saved: {failure}") from None
        return Json(Saved(name), status_code=201, headers={"Location": f"/api/v1/recordings/{name}"})

    @router.get(
        "/recordings/{name}",
        response_class=Download,
        summary="Download a recording",
        responses={
            200: {"content": {MCAP: {"schema": BYTES}}, "description": "The MCAP file."},
            206: {"content": {MCAP: {"schema": BYTES}}, "description": "The part of it asked for with `Range`."},
            **problems(404, 409, 416, 422),
        },
    )
    async def download_recording(name: Name, request: Request) -> Response:
        """The file as it is, to open here or in Foxglove, Rerun and other MCAP tools. `Range` is understood."""
        path = await _closed(name)
        try:
            status = await _on_disk(path.stat)
        except FileNotFoundError:
            raise _no_such(name) from None
        return Download.of(path, status, request.headers.get("range"))

    @router.delete(
        "/recordings/{name}", status_code=204, summary="Delete a recording", responses=problems(404, 409, 422)
    )
    async def delete_recording(name: Name) -> Response:
        """For good. One that is being written is refused: stop first; so is one that is being replayed, here or in a
        replay that was started here: end that first."""
        path = await _closed(name)
        if replays.replays(name):
            raise Problem(
                409,
                "recording-replayed",
                f"{name} is being replayed: end the replay first, with DELETE /api/v1/recordings/{name}/replay.",
            )
        if played is not None and await _on_disk(_same, path, played):
            raise Problem(409, "recording-replayed", f"{name} is what this console replays: end the replay first.")
        try:
            await _on_disk(catalog.delete, name)
        except FileNotFoundError:
            raise _no_such(name) from None
        return Response(status_code=204)

    @router.post(
        "/recordings/{name}/replay",
        response_model=ReplayReport,
        status_code=201,
        summary="Replay a recording",
        responses=problems(404, 409, 422, 502),
    )
    async def replay_recording(name: Name, request: Request) -> Response:
        """Starts `hbba replay` with a console of its own and answers once that is up, within seconds. A replay started
        here before is ended. It ends with this console, and by itself three minutes after its last viewer left."""
        path = await _closed(name)
        try:
            await replays.start(name, path)
        except ReplayReplaced as refusal:
            raise Problem(409, "replay-replaced", f"{name} is not replayed: {refusal}.") from None
        except ReplayFailed as failure:
            raise Problem(502, "replay-failed", f"{name} cannot be replayed: {failure}") from None
        running = _replay(replays, request)
        if running is None or running.name != name:
            raise Problem(409, "replay-replaced", f"{name} is not replayed any more: it was ended meanwhile.")
        return Json(running, status_code=201)

    @router.delete("/recordings/{name}/replay", status_code=204, summary="End a replay", responses=problems(404, 422))
    async def end_replay(name: Name) -> Response:
        _checked(name)
        if not await replays.end(name):
            raise Problem(404, "no-such-replay", f"{name} is not being replayed by this console.")
        return Response(status_code=204)

    def _checked(name: str) -> FilePath:
        try:
            return system.recordings.path(name)
        except ValueError as refusal:
            raise Problem(422, "invalid-name", f"{refusal}.", errors=[("path.name", str(refusal))]) from None

    async def _closed(name: str) -> FilePath:
        """Where the recording is; refused where there is none, or while it is being written."""
        path = _checked(name)
        try:
            written = report.writes(name) or await _on_disk(catalog.written, name)
        except FileNotFoundError:
            raise _no_such(name) from None
        if written:
            raise Problem(
                409, "recording-in-progress", f"{name} is being written: stop first, with POST /api/v1/recordings/stop."
            )
        return path

    async def _need_free(name: str) -> None:
        if name and (report.writes(name) or await _on_disk(catalog.has, name)):
            raise Problem(409, "recording-exists", f"There is a recording called {name} already; choose another name.")

    return router


def _same(path: FilePath, other: FilePath) -> bool:
    try:
        return path.samefile(other)
    except FileNotFoundError:
        return False


def _recording(recording: Recording, report: RecorderWatch) -> RecordingReport:
    ours, status = report.writes(recording.name), report.status
    return RecordingReport(
        name=recording.name,
        bytes=recording.bytes,
        duration_s=_rounded(status.duration_s if ours else recording.duration_s),
        began=status.began if ours else recording.begin,
        state="recording" if ours else recording.state,
        robot=recording.robot,
    )


def _rounded(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds, 3)


def _replay(replays: Replays, request: Request) -> ReplayReport | None:
    if (current := replays.current) is None:
        return None
    name, url = current
    identity = identity_of(request.scope)
    if identity is None or identity.role is not Role.SUPERVISOR:
        url = url.partition("#")[0]  # the token behind it is a supervisor's
    return ReplayReport(name, reached_by(url, request.url.scheme, request.url.hostname))


def _need_recorder(report: RecorderWatch) -> None:
    if not report.available:
        now = report.report()
        why = (now.reason if now is not None else "") or "this program has no Recorder at work, or no strategy for it"
        raise Problem(409, "recorder-missing", f"Nothing can be recorded: {why}.")


async def _on_disk(function: Callable[..., T], *args: Any) -> T:
    """``function(*args)`` in a thread. Raises Problem where the disk refuses, FileNotFoundError as it is."""
    try:
        return await asyncio.to_thread(function, *args)
    except FileNotFoundError:
        raise
    except OSError as failure:
        raise Problem(
            409, "disk-refuses", f"The disk refuses: {failure.filename}: {failure.strerror or failure}."
        ) from None


def _no_such(name: str) -> Problem:
    return Problem(404, "no-such-recording", f"No recording is called {name}; GET /api/v1/recordings lists all.")

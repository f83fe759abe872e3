"""A development tool: fakes the console's stream and REST, so that the page can be worked on without a robot.

    python web/dev/mock_server.py [--port 8099] [--token TOKEN] [--replay]

Nothing it says is computed by the attention: desires are weighed by a rule of thumb, the robot is a point that turns.
`POST /mock {"frozen": true, "silent": true, "empty": true, "world_rate": 0.85}` puts it into states the page must show;
further modes are those of the mock's recorder. With `--replay` it is the console of a recording.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import itertools
import json
import math
import time
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import FastAPI, Request, WebSocket, WebSocketDisconnect
from fastapi.responses import FileResponse, HTMLResponse, JSONResponse, Response
from fastapi.staticfiles import StaticFiles
from mock_map import MockMap, map_router, offer
from mock_playback import MockPlayback, playback_router
from mock_recordings import MockRecorder, recordings_router
from mock_robot import CLASSES, Mock, Viewer, picture, problem
from mock_senses import panorama, perceived, sound

STATIC = Path(__file__).parents[2] / "app" / "console" / "static"
FOOTPRINT = [[0.3 * math.cos(a), 0.3 * math.sin(a)] for a in (i * math.pi / 8 for i in range(16))]
UNMONITORED = {
    "title": "No collision monitor",
    "text": "IRL-1/TR runs with its collision monitor switched off (collision_monitor: off): nothing keeps it from "
    "driving into things",
    "where": "config/lab.yaml:101",
}
SCENE = Path(__file__).parent / "mock_scene.html"


def build(mock: Mock, playback: MockPlayback | None, static: Path) -> FastAPI:
    recorder = MockRecorder(mock)
    place = MockMap(mock)

    @contextlib.asynccontextmanager
    async def lifespan(_: FastAPI) -> Any:
        task = asyncio.create_task(beat(mock, recorder, playback, place))
        yield
        task.cancel()

    app = FastAPI(lifespan=lifespan)
    allowed = lambda cookies: mock.token is None or cookies.get("session") == mock.token  # noqa: E731

    @app.post("/mock")
    async def mode(request: Request) -> dict[str, Any]:
        change = await request.json()
        mock.mode |= change
        if playback is None:
            recorder.tell()
        if change.get("empty"):
            mock.desires.clear()
            mock.events.clear()
            mock.changed()
        return mock.mode

    @app.get("/api/v1/session")
    async def session(request: Request) -> Response:
        return (
            JSONResponse({"ok": True})
            if allowed(request.cookies)
            else problem(401, "Not logged in", "A token is needed.")
        )

    @app.post("/api/v1/session")
    async def log_in(request: Request) -> Response:
        if (await request.json()).get("token") != mock.token:
            return problem(
                401, "Wrong token", "This is not the console's token. It is printed when the console starts."
            )
        answer = Response(status_code=204)
        answer.set_cookie("session", mock.token or "", httponly=True, samesite="strict")
        return answer

    @app.get("/panels/index.json")
    async def panels() -> list[Any]:
        return []

    @app.get("/api/v1/timeline")
    async def timeline(limit: int = 200) -> dict[str, Any]:
        return {"events": mock.events[-limit:]}

    @app.post("/api/v1/desires")
    async def add(request: Request) -> Response:
        body = await request.json()
        if body.get("class") not in {c[0] for c in CLASSES}:
            return problem(
                422,
                "Unknown desire class",
                f"There is no class {body.get('class')!r}.",
                [{"field": "class", "message": "Unknown class."}],
            )
        if body["class"] == "GoTo" and math.hypot(body["params"]["x"], body["params"]["y"]) > 20:
            errors = [{"field": "params.x", "message": "Outside of the map, which ends at 10 m."}]
            return problem(422, "The desire cannot be taken", "One parameter is out of its range.", errors)
        return JSONResponse(mock.add(body, "operator", request.headers.get("x-hbba-operator", "?")), 201)

    @app.patch("/api/v1/desires/{id}")
    async def change(id: str, request: Request) -> Response:
        if id not in mock.desires:
            return problem(404, "No such desire", "It has expired or was removed.")
        mock.desires[id] |= await request.json()
        mock.log("desire", mock.desires[id]["class"], f"{mock.desires[id]['class']} was changed.")
        mock.changed()
        return JSONResponse(mock.desires[id])

    @app.delete("/api/v1/desires/{id}")
    async def remove(id: str) -> Response:
        if mock.desires.pop(id, None) is None:
            return problem(404, "No such desire", "It has expired or was removed.")
        mock.changed()
        return Response(status_code=204)

    @app.websocket("/api/v1/live")
    async def live(socket: WebSocket, operator: str = "operator") -> None:
        if not allowed(socket.cookies) or mock.mode.get("refuse"):
            await socket.close()
            return
        await socket.accept()
        viewer = Viewer(socket, operator)
        mock.viewers[viewer.session] = viewer
        greet(mock, viewer, playback, place)
        if playback is None:
            viewer.send(recorder.status())
        pump = asyncio.create_task(viewer.pump())
        try:
            while True:
                frame = await socket.receive()
                if frame["type"] == "websocket.disconnect":
                    break
                if frame.get("text"):
                    hear(mock, viewer, json.loads(frame["text"]))
        except WebSocketDisconnect:
            pass
        finally:
            pump.cancel()
            mock.viewers.pop(viewer.session, None)
            if mock.driver == viewer.session:
                mock.driver = None

    app.include_router(map_router(mock, place))
    app.include_router(recordings_router(mock, recorder))
    app.include_router(playback_router(playback))

    @app.get("/viser/")
    async def scene() -> HTMLResponse:
        return HTMLResponse(SCENE.read_text())

    @app.get("/")
    async def index() -> FileResponse:
        return FileResponse(static / "index.html")

    app.mount("/", StaticFiles(directory=static))
    return app


def greet(mock: Mock, viewer: Viewer, playback: MockPlayback | None, place: MockMap) -> None:
    limits = {"linear_mps": 0.4, "angular_radps": 1.0, "linear_mps2": 0.4, "angular_radps2": 4.0}
    classes = [
        {
            "name": n,
            "title": "",
            "description": d,
            "served": True,
            "schema": {"type": "object", "properties": p, "required": [k for k, v in p.items() if "default" not in v]},
        }
        for n, d, _, p in CLASSES
    ]
    viewer.send(
        {
            "type": "hello",
            "protocol": 1,
            "session": viewer.session,
            "stamp": mock.now(),
            "robot": {
                "name": "IRL-1/TR",
                "simulated": True,
                "replayed": playback is not None,
                "limits": limits,
                "footprint": FOOTPRINT,
                "cautions": [UNMONITORED] if mock.mode.get("unmonitored") else [],
            },
            "scale": {"intensity": 8, "utility": 8},
            "classes": classes,
            "channels": {
                "camera": True,
                "panorama": not mock.mode.get("no_panorama"),
                "map": not mock.mode.get("no_slam"),
                "costmap": True,
                "scan": True,
                "point_cloud": True,
            },
            "drive": not mock.mode.get("no_wheels") and playback is None,
            "audio": {"listen": not mock.mode.get("deaf"), "speak": not mock.mode.get("mute")},
            "playback": playback and playback.json(),
        }
    )
    viewer.send({"type": "desires", "desires": list(mock.desires.values())})
    viewer.send({"type": "intention", "intention": mock.intention()})
    viewer.send({"type": "zones", "zones": place.zones})
    viewer.send(mock.landmarks() if not mock.mode.get("empty") else {"type": "landmarks", "landmarks": []})


def hear(mock: Mock, viewer: Viewer, message: dict[str, Any]) -> None:
    kind = message["type"]
    if kind == "ping" and not mock.mode.get("silent"):
        viewer.send({"type": "pong", "t": message["t"], "stamp": mock.now()})
    elif kind == "drive":
        if mock.driver is None and message["held"]:
            mock.driver = viewer.session
        if mock.driver == viewer.session:
            mock.target = [message["linear"], message["angular"]] if message["held"] else [0.0, 0.0]
            mock.commanded = time.time()
        elif message["held"]:
            viewer.send({"type": "notice", "level": "warning", "text": f"{mock.viewers[mock.driver].operator} drives."})
    elif kind == "e_stop":
        mock.e_stopped = True
        mock.log("e_stop", None, f"Emergency stop by {viewer.operator}.")
    elif kind == "clear_e_stop":
        mock.e_stopped = False
        mock.log("e_stop", None, f"Emergency stop released by {viewer.operator}.")
    elif kind == "take_control":
        mock.driver = viewer.session
    elif kind == "release_control" and mock.driver == viewer.session:
        mock.driver = None
    elif kind == "ack":
        viewer.under_way[message["kind"]] = False
    elif kind == "view":
        for number, name in ((1, "camera"), (2, "panorama"), (3, "map"), (4, "costmap")):
            if name in message:
                viewer.wants[number] = message[name]
                viewer.under_way[number] = False
    elif kind == "listen":
        viewer.listens, viewer.heard_until = message["on"], mock.now()


async def beat(mock: Mock, recorder: MockRecorder, playback: MockPlayback | None, place: MockMap) -> None:
    for seq in itertools.count():
        await asyncio.sleep(0.05)
        mock.advance(0.05)
        place.advance(0.05)
        gone = [d["id"] for d in mock.desires.values() if d["expires"] and d["expires"] < time.time()]
        for desire in gone:
            mock.log("desire", mock.desires.pop(desire)["class"], "A desire ran out of time.")
        if gone:
            mock.changed()
        if mock.mode.get("frozen") or mock.mode.get("silent"):
            continue
        if playback and seq % 2 == 0:
            playback.beat()
        if playback and not playback.playing and seq % 20:
            continue
        if playback is None and seq % 20 == 0:
            recorder.tell()
        for viewer in list(mock.viewers.values()):
            viewer.send(mock.status(viewer, seq))
            viewer.send({"type": "lanes", "seq": seq, "stamp": mock.now(), "rows": mock.lanes()})
            if seq % 20 == 0:
                viewer.send(mock.load())
            seen = mock.share()["Telepresence"][0] is not None
            if seq % 2 == 0:
                viewer.send(perceived(mock))
                offer(place, viewer, seq)
            for number, made in ((1, picture), (2, panorama)):
                missing = number == 2 and mock.mode.get("no_panorama")
                if viewer.wants[number] and not missing and seen and not viewer.under_way[number] and seq % 2 == 0:
                    viewer.under_way[number] = True
                    viewer.outbox.put_nowait(made(mock, seq))
            while viewer.listens and viewer.heard_until < mock.now() - 0.02:
                viewer.outbox.put_nowait(sound(viewer.heard_until, viewer.sounds))
                viewer.heard_until += 0.02
                viewer.sounds += 1


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--port", type=int, default=8099)
    parser.add_argument("--token")
    parser.add_argument("--static", type=Path, default=STATIC, help="where the built page lies")
    parser.add_argument("--replay", action="store_true", help="be the console of a replay")
    parser.add_argument("--slow", type=float, help="the fastest speed that the replay reaches")
    options = parser.parse_args()
    mock = Mock(options.token)
    playback = MockPlayback(mock.tell, options.slow) if options.replay else None
    if playback:
        mock.now = playback.now
    uvicorn.run(build(mock, playback, options.static), host="127.0.0.1", port=options.port, log_level="warning")

"""The mock robot's map: a floor plan, a robot that goes straight to its goal, zones and kept maps."""

from __future__ import annotations

import asyncio
import json
import math
import struct
import time
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse, Response
from mock_robot import problem

if TYPE_CHECKING:
    from mock_robot import Mock

CELL = 0.05
ORIGIN = (-12.0, -6.0)
SIZE = (480, 400)
X_MO = (0.35, -0.2, 0.06)


class MockMap:
    """What is known of the place, and where the robot goes in it."""

    def __init__(self, mock: Mock) -> None:
        self.mock = mock
        self.name = "ground-floor"
        self.zones: list[dict[str, Any]] = [
            {
                "name": "Stairs",
                "kind": "keep_out",
                "polygon": [[-9, 4.2], [-6.4, 4.2], [-6.4, 6.4], [-9, 6.4]],
                "speed": 1,
            },
            {
                "name": "Kitchen",
                "kind": "slow",
                "polygon": [[2, -4.4], [7, -4.4], [7.6, -1.2], [2, -1.2]],
                "speed": 0.4,
            },
        ]
        self.kept = {"ground-floor": time.time() - 8000, "first-floor": time.time() - 900_000}
        self.cells = floor_plan()
        self.state = "idle"
        self.goal: dict[str, Any] | None = None
        self.version = 1

    def pose(self) -> list[float]:
        """On the map."""
        x, y, turn = X_MO
        ox, oy, theta = self.mock.pose
        c, s = math.cos(turn), math.sin(turn)
        return [x + c * ox - s * oy, y + s * ox + c * oy, theta + turn]

    def advance(self, dt: float) -> None:
        """Straight there, turning first."""
        desire = self.mock.strongest("GoTo")
        self.goal = None if desire is None else desire["params"]
        if self.goal is None:
            self.state = "idle" if self.state != "arrived" else "arrived"
            return
        x, y, theta = self.pose()
        dx, dy = self.goal["x"] - x, self.goal["y"] - y
        far = math.hypot(dx, dy)
        way = self.mock.mode.get("way")
        self.state = way or ("following" if far > 0.1 else "arrived")
        if way or self.mock.e_stopped:
            return
        if far < 0.1:
            self.mock.desires.pop(desire["id"], None)
            self.mock.changed()
            return
        turn = math.atan2(math.sin(math.atan2(dy, dx) - theta), math.cos(math.atan2(dy, dx) - theta))
        step = 0.5 * dt if abs(turn) < 0.4 else 0.0
        self.mock.pose[2] += max(-1.2 * dt, min(1.2 * dt, turn))
        self.mock.pose[0] += step * math.cos(self.mock.pose[2])
        self.mock.pose[1] += step * math.sin(self.mock.pose[2])

    def localization(self) -> dict[str, Any]:
        x, y, theta = self.pose()
        state = self.mock.mode.get("place", "tracking")
        sigma = [0.02, 0.035, 0.01] if state in ("tracking", "mapping") else [1.2, 0.8, 0.5]
        place = dict(zip(("x", "y", "theta"), X_MO, strict=True))
        facts = {"stamp": self.mock.now(), "state": state, "map": "" if state == "mapping" else self.name}
        return {
            "type": "localization",
            **facts,
            "x": x,
            "y": y,
            "theta": theta,
            "sigma": sigma,
            "X_MO": place,
            "overlap": 0.9,
        }

    def navigation(self) -> dict[str, Any]:
        x, y, _ = self.pose()
        goal = self.goal and {"x": self.goal["x"], "y": self.goal["y"], "theta": self.goal.get("heading")}
        path, left = [], None
        if goal:
            side = (0.5 * (x + goal["x"]) - 0.15 * (goal["y"] - y), 0.5 * (y + goal["y"]) + 0.15 * (goal["x"] - x))
            ts = np.linspace(0, 1, 30)
            path = [
                [
                    float((1 - t) ** 2 * x + 2 * t * (1 - t) * side[0] + t * t * goal["x"]),
                    float((1 - t) ** 2 * y + 2 * t * (1 - t) * side[1] + t * t * goal["y"]),
                ]
                for t in ts
            ]
            left = math.hypot(goal["x"] - x, goal["y"] - y)
        reasons = {
            "waiting": "a person stands in the way; it goes on when they have left",
            "unreachable": "walls all around it, or a zone to keep out of",
            "recovering": "something lies 0.2 m ahead",
        }
        return {
            "type": "navigation",
            "stamp": self.mock.now(),
            "behavior": "PlanAndFollowPath",
            "state": self.state,
            "reason": reasons.get(self.state, ""),
            "goal": goal,
            "target": self.mock.mode.get("target") or goal,
            "remaining_m": left,
            "recoveries": 2 if self.state == "recovering" else 0,
            "desire": None,
            "path": path if self.state in ("following", "waiting", "recovering") else [],
            "given_up": None if goal else self.mock.mode.get("given_up"),
        }

    def grid(self, kind: int, seq: int) -> tuple[dict[str, Any], bytes]:
        """A map (3) or costmap (4): its info and its binary frame."""
        if kind == 3:
            cells, cell, origin, frame = self.cells, CELL, ORIGIN, "map"
        else:
            x, y, _ = self.mock.pose
            cells, cell, origin, frame = costmap(), 0.025, (x - 2.0, y - 2.0), "odom"
        grey = np.where(cells < 0, 255, cells).astype(np.uint8)[::-1]
        height, width = grey.shape
        info = {
            "type": "map_info" if kind == 3 else "costmap_info",
            "seq": seq,
            "stamp": self.mock.now(),
            "frame": frame,
            "version": self.version,
            "resolution_m": cell,
            "origin": list(origin),
            "width": width,
            "height": height,
        }
        png = cv2.imencode(".png", grey)[1].tobytes()
        return info, struct.pack("<B3xIdHH4x", kind, seq, self.mock.now(), width, height) + png


def floor_plan() -> np.ndarray:
    """Rooms along a corridor, as a laser that went through them leaves them: (H, W) int16, row 0 at the bottom."""
    cells = np.full((SIZE[1], SIZE[0]), -1, np.int16)

    def box(x0: float, y0: float, x1: float, y1: float, value: int) -> None:
        column = lambda x: round((x - ORIGIN[0]) / CELL)  # noqa: E731
        row = lambda y: round((y - ORIGIN[1]) / CELL)  # noqa: E731
        cells[max(0, row(y0)) : row(y1), max(0, column(x0)) : column(x1)] = value

    for x0, y0, x1, y1 in (
        (-10, -1, 11, 1.2),
        (-10, 1.2, -1, 7.5),
        (-1, 1.2, 11, 7.5),
        (1, -5, 8, -1),
        (-6, -5, 1, -1),
    ):
        box(x0 - 0.1, y0 - 0.1, x1 + 0.1, y1 + 0.1, 100)
        box(x0, y0, x1, y1, 0)
    for x0, y0, x1, y1 in ((-5, 1.0, -4, 1.4), (3, 1.0, 4.1, 1.4), (4, -1.2, 5, -0.8), (-3, -1.2, -2, -0.8)):
        box(x0, y0, x1, y1, 0)
    for x0, y0, x1, y1 in (
        (5, 4, 7, 4.8),
        (-8, 3, -7.4, 3.6),
        (8.6, -0.4, 9.2, 0),
        (2, -4, 3, -3.4),
        (0.4, 5, 0.6, 5.2),
    ):
        box(x0, y0, x1, y1, 100)
        box(x0 + 0.1, y0 + 0.1, x1 - 0.1, y1 - 0.1, -1)
    random = np.random.default_rng(1)
    rim = cells == 100
    cells[rim] = np.clip(100 - random.exponential(9, int(rim.sum())), 60, 100).astype(np.int16)
    cells[(random.random(cells.shape) < 0.25) & (cells == -1)] = -1
    cells[: round(1.8 / CELL), -60:] = -1
    return cells


def costmap() -> np.ndarray:
    """4 × 4 m around the robot: something ahead on the left."""
    y, x = np.mgrid[-80:80, -80:80] * 0.025
    far = np.hypot(x - 1.1, y - 0.5) - 0.25
    cost = np.where(far < 0, 100, np.clip(95 * np.exp(-4 * far), 0, 99))
    return np.where(cost < 6, 0, cost).astype(np.int16)


def map_router(mock: Mock, place: MockMap) -> APIRouter:
    """REST of maps and goals."""
    router = APIRouter(prefix="/api/v1")

    def tell_zones() -> None:
        mock.tell({"type": "zones", "zones": place.zones})

    @router.get("/maps")
    async def maps() -> Response:
        facts = {"size_m": [22.1, 12.6], "resolution_m": 0.05, "known_m2": 141.3, "extendable": True, "problem": None}
        listed = [
            {"name": n, "in_use": n == place.name, "saved": at, "zones": 2 if n == place.name else 0, **facts}
            for n, at in sorted(place.kept.items())
        ]
        if "first-floor" in place.kept:
            listed[0] |= {"extendable": False}
        current = {"available": True, "name": place.name, "state": "tracking", "stamp": mock.now()}
        return JSONResponse({"folder": "/home/ann/.local/share/hbba/maps", "current": current, "maps": listed})

    @router.put("/maps/{name}")
    async def save(name: str) -> Response:
        await asyncio.sleep(0.8)
        place.kept[name] = time.time()
        place.name = name
        mock.mode["place"] = "tracking"
        return JSONResponse({})

    @router.post("/maps/{name}/load")
    async def load(name: str, request: Request) -> Response:
        await asyncio.sleep(1)
        if mock.mode.get("load_fails"):
            return problem(409, "Unreadable map", "The map's files are damaged: map.pgm is cut off.")
        place.name = name
        mock.mode["place"] = "tracking" if (await request.json()).get("pose") else "searching"
        return JSONResponse({})

    @router.patch("/maps/{name}")
    async def rename(name: str, request: Request) -> Response:
        place.kept[(await request.json())["name"]] = place.kept.pop(name)
        return JSONResponse({})

    @router.delete("/maps/{name}")
    async def delete(name: str) -> Response:
        place.kept.pop(name, None)
        return Response(status_code=204)

    @router.get("/maps/{name}/picture")
    async def picture(name: str) -> Response:
        shown = np.where(place.cells < 0, 205, 254 - 2.5 * place.cells).clip(0, 254).astype(np.uint8)[::-1]
        return Response(cv2.imencode(".png", shown)[1].tobytes(), media_type="image/png")

    @router.post("/map/begin")
    async def begin() -> Response:
        place.name = ""
        mock.mode["place"] = "mapping"
        return JSONResponse({})

    @router.put("/map/pose")
    async def pose(request: Request) -> Response:
        body = await request.json()
        c, s = math.cos(X_MO[2]), math.sin(X_MO[2])
        dx, dy = body["x"] - X_MO[0], body["y"] - X_MO[1]
        mock.pose[:] = [c * dx + s * dy, -s * dx + c * dy, body["theta"] - X_MO[2]]
        mock.mode["place"] = "tracking"
        return JSONResponse({})

    @router.post("/map/search")
    async def search() -> Response:
        mock.mode["place"] = "searching"
        return JSONResponse({})

    @router.put("/map/zones")
    async def zones(request: Request) -> Response:
        if mock.mode.get("zones_fail"):
            return problem(422, "Invalid request", "zones.0.polygon: its corners lie on one line.")
        place.zones = (await request.json())["zones"]
        tell_zones()
        return JSONResponse({"zones": place.zones})

    @router.put("/goal")
    async def go(request: Request) -> Response:
        params = await request.json()
        for one in [d for d in mock.desires.values() if d["class"] == "GoTo"]:
            mock.desires.pop(one["id"])
        body = {"class": "GoTo", "intensity": 8, "utility": 1, "params": params}
        return JSONResponse(mock.add(body, "operator", request.headers.get("x-hbba-operator", "?")))

    @router.delete("/goal")
    async def cancel() -> Response:
        for one in [d for d in mock.desires.values() if d["class"] == "GoTo"]:
            mock.desires.pop(one["id"])
        mock.changed()
        return Response(status_code=204)

    return router


def offer(place: MockMap, viewer: Any, seq: int) -> None:
    """What is told ten times a second, and the pictures that are asked for."""
    if place.mock.mode.get("no_map"):
        return
    viewer.send(place.localization())
    viewer.send(place.navigation())
    for kind, every in ((3, 10), (4, 4)):
        if viewer.wants.get(kind) and not viewer.under_way.get(kind) and seq % every == 0:
            viewer.under_way[kind] = True
            info, frame = place.grid(kind, seq)
            viewer.outbox.put_nowait(json.dumps(info))
            viewer.outbox.put_nowait(frame)

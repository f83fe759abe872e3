"""The robot that the mock console pretends to have; see mock_server.py."""

from __future__ import annotations

import asyncio
import itertools
import json
import math
import random
import struct
import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from fastapi import WebSocket
from fastapi.responses import JSONResponse

CLASSES: list[tuple[str, str, float, dict[str, Any]]] = [
    ("Telepresence", "Show people what the robot sees", 20, {}),
    ("FindQRCodes", "Find QR codes in the camera's pictures", 80, {}),
    ("LocateFaces", "Find faces and where they are", 60, {}),
    ("LocateVoices", "Tell where voices come from", 10, {}),
    (
        "DetectNoises",
        "Notice loud noises",
        5,
        {"threshold": {"type": "number", "minimum": 2, "maximum": 100, "default": 20}},
    ),
    ("SLAM", "Map the place and know where it is", 20, {}),
    ("Teleoperation", "Let a person drive", 0, {}),
    (
        "GoTo",
        "Go to a place on the map",
        30,
        {
            "x": {"type": "number", "title": "X", "description": "metres, in the map", "minimum": -50, "maximum": 50},
            "y": {"type": "number", "title": "Y", "description": "metres, in the map", "minimum": -50, "maximum": 50},
            "heading": {
                "anyOf": [{"type": "number"}, {"type": "null"}],
                "title": "Heading",
                "description": "radians",
                "default": None,
            },
            "style": {"enum": ["direct", "planned"], "type": "string", "default": "planned"},
            "announce": {"type": "boolean", "default": False, "title": "Announce the arrival"},
        },
    ),
]


def problem(status: int, title: str, detail: str, errors: list[dict[str, str]] | None = None) -> JSONResponse:
    return JSONResponse(
        {"type": "about:blank", "title": title, "status": status, "detail": detail, "errors": errors or []},
        status,
        media_type="application/problem+json",
    )


class Mock:
    def __init__(self, token: str | None) -> None:
        self.token = token
        self.mode: dict[str, Any] = {}
        self.desires: dict[str, dict[str, Any]] = {}
        self.events: list[dict[str, Any]] = []
        self.pose = [0.0, 0.0, 0.0]
        self.target = [0.0, 0.0]
        self.speed = [0.0, 0.0]
        self.commanded = 0.0
        self.e_stopped = False
        self.driver: str | None = None
        self.viewers: dict[str, Viewer] = {}
        self.ids = itertools.count(1)
        self.now: Callable[[], float] = time.time
        self.began = time.time()
        for name, kind in (
            ("Telepresence", "motivation"),
            ("FindQRCodes", "motivation"),
            ("Teleoperation", "motivation"),
            ("SLAM", "motivation"),
        ):
            self.add(
                {
                    "class": name,
                    "intensity": 8 if name != "FindQRCodes" else 4,
                    "utility": 1,
                    "security": name == "Teleoperation",
                },
                kind,
                "ScenarioCoordinator",
            )

    def log(self, kind: str, subject: str | None, text: str, **data: Any) -> None:
        event = {
            "id": next(self.ids),
            "stamp": self.now(),
            "kind": kind,
            "subject": subject,
            "text": text,
            "data": data,
        }
        self.events = [*self.events[-999:], event]
        self.tell({"type": "events", "events": [event]})

    def tell(self, message: dict[str, Any]) -> None:
        for viewer in self.viewers.values():
            viewer.send(message)

    def add(self, body: dict[str, Any], kind: str, who: str) -> dict[str, Any]:
        now = self.now()
        desire = {
            "id": f"d{next(self.ids)}",
            "class": body["class"],
            "intensity": body.get("intensity", 4),
            "utility": body.get("utility", 1),
            "security": body.get("security", False),
            "params": body.get("params", {}),
            "source": {"kind": kind, "name": who},
            "created": now,
            "expires": now + body["ttl"] if body.get("ttl") else None,
        }
        self.desires[desire["id"]] = desire
        self.log(
            "desire",
            desire["class"],
            f"{who} desires {desire['class']} (intensity {desire['intensity']}, utility {desire['utility']}).",
        )
        self.changed()
        return desire

    def changed(self) -> None:
        self.tell({"type": "desires", "desires": list(self.desires.values())})
        self.tell({"type": "intention", "intention": self.intention()})

    def strongest(self, name: str) -> dict[str, Any] | None:
        return max((d for d in self.desires.values() if d["class"] == name), key=lambda d: d["intensity"], default=None)

    def share(self) -> dict[str, tuple[int | None, str, str]]:
        """Class -> divisor, state, text: most intense first, each takes the least divisor that still fits."""
        room, result = 100.0, {}
        order = sorted(CLASSES, key=lambda c: -((self.strongest(c[0]) or {"intensity": -1})["intensity"]))
        for name, _, cost, _ in order:
            wish = self.strongest(name)
            if wish is None:
                result[name] = (None, "undesired", "Nobody desires it, so nothing is let through.")
            elif wish["utility"] == 0:
                result[name] = (None, "inhibited", "A desire of utility 0 silences it.")
            else:
                phi = next((p for p in (1, 2, 4, 8) if cost / p <= room), None)
                if phi is None:
                    result[name] = (
                        None,
                        "unfulfilled",
                        f"Needs {cost / 8:.0f} % CPU, {room:.0f} % are left; would fit without SLAM.",
                    )
                else:
                    room -= cost / phi
                    text = (
                        "Fits with all its messages."
                        if phi == 1
                        else f"One message of {phi} fits into the {room + cost / phi:.0f} % CPU left."
                    )
                    result[name] = (phi, "fulfilled" if 8 / phi >= wish["utility"] else "degraded", text)
        return result

    def lanes(self) -> list[dict[str, Any]]:
        rows = []
        for name, (phi, state, text) in ((c[0], self.share()[c[0]]) for c in CLASSES):
            wish = self.strongest(name)
            rate = 0.0 if phi is None else min(1.0, max(0.0, 1 / phi + random.uniform(-0.015, 0.015) * (phi > 1)))
            rows.append(
                {
                    "class": name,
                    "intensity": wish and wish["intensity"],
                    "utility": wish and wish["utility"],
                    "rate": rate,
                    "divisor": phi,
                    "state": state,
                    "text": text,
                }
            )
        return rows

    def intention(self) -> dict[str, Any]:
        share = self.share()
        chosen = [(c, share[c[0]][0]) for c in CLASSES if share[c[0]][0] is not None]
        port = {
            "FindQRCodes": "QRCodeDetector.images",
            "LocateFaces": "FaceDetector.images",
            "SLAM": "SLAM.scans",
            "Telepresence": "Encoder.images",
        }
        strategies = [
            {
                "name": f"{c[0]}_phi{phi}",
                "class": c[0],
                "utility": 8 / phi,
                "filters": {port.get(c[0], f"{c[0]}.commands"): phi},
                "costs": {"cpu": c[2] / phi},
            }
            for c, phi in chosen
            if phi
        ]
        reasons = {}
        for name, (phi, state, text) in share.items():
            wish = self.strongest(name)
            if wish:
                reasons[name] = {
                    "state": state,
                    "utility": 8 / phi if phi else 0,
                    "wanted": wish["utility"],
                    "best": 8,
                    "text": text,
                    "alternatives": [],
                }
        used = sum(s["costs"]["cpu"] for s in strategies)
        omega = sum(d["intensity"] for d in self.desires.values()) + sum(s["utility"] for s in strategies)
        return {
            "stamp": self.now(),
            "strategies": strategies,
            "fulfilled": [n for n, (_, state, _) in share.items() if state == "fulfilled"],
            "omega": omega,
            "use": {"cpu": {"used": used, "capacity": 100, "unit": "%"}},
            "filters": {k: v for s in strategies for k, v in s["filters"].items()},
            "proven": True,
            "solve_ms": 1.7,
            "relaxed": [],
            "reasons": reasons,
            "bound": omega,
            "parameters": {},
            "desires": {name: wish["id"] for name in share if (wish := self.strongest(name))},
        }

    def advance(self, dt: float) -> None:
        fresh = time.time() - self.commanded < 0.2 and not self.e_stopped
        for i, most in ((0, 0.4), (1, 1.0)):
            goal = self.target[i] * most if fresh else 0.0
            step = (0.4, 4.0)[i] * dt
            self.speed[i] += max(-step, min(step, goal - self.speed[i])) if not self.e_stopped else -self.speed[i]
        self.pose[2] += self.speed[1] * dt
        self.pose[0] += self.speed[0] * math.cos(self.pose[2]) * dt
        self.pose[1] += self.speed[0] * math.sin(self.pose[2]) * dt

    def status(self, viewer: Viewer, seq: int) -> dict[str, Any]:
        age = (time.time() - self.commanded) * 1000 if self.commanded else None
        moving = age is not None and age < 200 and any(self.target)
        state = (
            "e_stopped"
            if self.e_stopped
            else "driving"
            if moving
            else "stale_command"
            if any(abs(s) > 0.01 for s in self.speed)
            else "idle"
        )
        applied = {"linear_mps": self.speed[0], "angular_radps": self.speed[1]}
        driver = self.viewers.get(self.driver or "")
        return {
            "type": "status",
            "seq": seq,
            "stamp": self.now(),
            "guard": {
                "state": state,
                "reason": "as the mock says",
                "e_stopped": self.e_stopped,
                "command_age_ms": age,
                "applied": applied,
            },
            "world_rate": self.mode.get("world_rate", 1.0),
            "odometry": {"x": self.pose[0], "y": self.pose[1], "theta": self.pose[2], **applied},
            "driver": {"operator": driver.operator, "mine": driver is viewer, "holds": moving} if driver else None,
            "speaker": {"operator": "Bea", "mine": False} if self.mode.get("other_speaks") else None,
            "exploited": "Teleop" if moving else None,
            "waits": self.mode.get("waits", ""),
            "sources": [{"channel": "kinect", "state": "live", "age_ms": 40, "rate_hz": 15, "expected_hz": 15}],
        }

    def load(self) -> dict[str, Any]:
        wave = 8 * math.sin(self.now() / 7)
        figures = [
            ("Kinect", "Kinect camera", 9.0),
            ("QRCodeDetector", "QR code detector", 24 + wave),
            ("Hokuyo", "Laser", 1.2),
            ("Odometry", "Odometry", 0.6),
        ]
        figures += [
            ("Teleop", "Teleoperation", 0.3),
            ("MobileBaseControl", "Mobile base control", 0.4),
            ("SLAM", "Map", 14 - wave / 3),
            ("FaceDetector", "Face detector", 0),
        ]
        inputs = [
            {
                "name": "images",
                "channel": "kinect",
                "divisor": 2,
                "received": 18234,
                "passed": 9117,
                "decimated": 9117,
                "dropped": 3,
                "age_ms": 41.2,
            }
        ]
        modules = [
            {
                "name": n,
                "title": t,
                "state": "running",
                "cpu": c,
                "message_cpu_us": 1800.0,
                "restarts": 0,
                "problem": None,
                "inputs": inputs if "Detector" in n else [],
                "outputs": [],
            }
            for n, t, c in figures
        ]
        modules[-1] |= {
            "state": "failed",
            "restarts": 3,
            "problem": "FaceDetector: model file faces.onnx is missing; put it into models/. Next try in 8 s.",
        }
        total = sum(m["cpu"] for m in modules) + 6
        return {"type": "load", "stamp": self.now(), "process_cpu": total, "budget": 100, "modules": modules}

    def landmarks(self) -> dict[str, Any]:
        found = [("tour:stop=robotics-lab;say=welcome", 3.1, 1.2, 1.4), ("tour:stop=workshop", -2.0, 4.4, 1.38)]
        now = self.now()
        return {
            "type": "landmarks",
            "landmarks": [
                {
                    "text": t,
                    "x": x,
                    "y": y,
                    "z": z,
                    "sigma_m": 0.04,
                    "sightings": 12 * i + 1,
                    "first_seen": self.began - 40,
                    "last_seen": now - 12 * (i + 1),
                }
                for i, (t, x, y, z) in enumerate(found)
            ],
        }


class Viewer:
    def __init__(self, socket: WebSocket, operator: str) -> None:
        self.socket, self.operator = socket, operator
        self.session = f"{random.getrandbits(48):x}"
        self.outbox: asyncio.Queue[str | bytes] = asyncio.Queue(1000)
        self.wants = {1: True, 2: False}
        self.under_way = {1: False, 2: False}
        self.listens, self.sounds = False, 0
        self.heard_until = 0.0

    def send(self, message: dict[str, Any]) -> None:
        self.outbox.put_nowait(json.dumps(message))

    async def pump(self) -> None:
        while True:
            item = await self.outbox.get()
            await (self.socket.send_text(item) if isinstance(item, str) else self.socket.send_bytes(item))


def picture(mock: Mock, seq: int) -> bytes:
    image = np.full((480, 640, 3), (64, 58, 50), np.uint8)
    shift = int(-mock.pose[2] * 600) % 160
    for x in range(-160 + shift, 800, 160):
        cv2.rectangle(image, (x, 90), (x + 120, 330), (96, 110, 120), -1)
        cv2.rectangle(image, (x + 30, 130), (x + 90, 210), (225, 230, 232), -1)
    cv2.rectangle(image, (0, 330), (640, 480), (70, 84, 92), -1)
    cv2.putText(
        image,
        time.strftime("%H:%M:%S", time.localtime(mock.now())),
        (20, 460),
        cv2.FONT_HERSHEY_SIMPLEX,
        0.8,
        (240, 240, 240),
        2,
    )
    jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 70])[1].tobytes()
    return struct.pack("<B3xIdHH4x", 1, seq, mock.now(), 640, 480) + jpeg

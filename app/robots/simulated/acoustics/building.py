"""Rooms of a world and the doors between them: sound paths between rooms.

Within a room sound travels straight. From another room it passes the doors on the shortest path: the listener hears it
from the last opening, with spreading over the whole length, diffracted around every edge (Z. Maekawa, "Noise reduction
by screens", Applied Acoustics 1, 1968), with some of the other room's reverberation. Transmission through walls is
negligible beside that (35 dB and more).
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.robots.simulated.acoustics.auralization import SoundPath
from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS
from app.robots.simulated.acoustics.room import Shoebox
from app.robots.simulated.world_config import DoorConfig, RoomConfig, WallConfig, WorldConfig

BAND_HZ = (700.0, 4000.0)
"""Middles of the two bands, for diffraction."""
#: Absorbed share of sound energy of surfaces, low and high band, by pattern: after H. Kuttruff, "Room Acoustics".
ABSORPTION = {
    "plain": (0.06, 0.06), "plaster": (0.04, 0.05), "brick": (0.03, 0.05), "wood": (0.10, 0.08),
    "planks": (0.08, 0.07), "carpet": (0.20, 0.45), "tiles": (0.02, 0.03), "terrazzo": (0.02, 0.02),
    "concrete": (0.03, 0.04), "ceiling": (0.45, 0.60), "books": (0.30, 0.40), "window": (0.10, 0.04),
}  # fmt: skip
FURNITURE_ABSORPTION = 0.12
"""Absorption of furniture, per square metre of floor."""
_AT_DOOR_M = 0.15


Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Opening:
    """A door or a gap between two rooms (their numbers): a segment on the floor plan, ``height`` m high."""

    rooms: tuple[int, int]
    start: tuple[float, float]
    end: tuple[float, float]
    height: float

    @property
    def area_m2(self) -> float:
        return math.dist(self.start, self.end) * self.height

    def beyond(self, room: int) -> int:
        return self.rooms[1] if self.rooms[0] == room else self.rooms[0]


class Building:
    """Rooms and openings of one world; a listener or source outside all rooms counts to the nearest."""

    def __init__(self, rooms: Sequence[Shoebox], openings: Sequence[Opening] = ()) -> None:
        self.rooms = tuple(rooms)
        self.openings = tuple(openings)
        self._of: dict[int, list[int]] = {number: [] for number in range(len(self.rooms))}
        for number, opening in enumerate(self.openings):
            for room in opening.rooms:
                self._of[room].append(number)
        self._plans = [(r.corner[0], r.corner[1], r.corner[0] + r.size[0], r.corner[1] + r.size[1]) for r in rooms]
        self._middles = [((o.start[0] + o.end[0]) / 2, (o.start[1] + o.end[1]) / 2) for o in openings]

    def room_at(self, p_W: Sequence[float]) -> int:
        """Number of the room that contains the point (m, world), else of the nearest."""
        x, y = float(p_W[0]), float(p_W[1])
        best, nearest = 0, math.inf
        for number, (x0, y0, x1, y1) in enumerate(self._plans):
            away = max(x0 - x, x - x1, 0.0) + max(y0 - y, y - y1, 0.0)
            if away < nearest:
                best, nearest = number, away
                if away == 0.0:
                    break
        return best

    def way(self, p_WS: NDArray[np.float64], p_WA: NDArray[np.float64]) -> SoundPath:
        # In plain floats: numpy is ten times slower for a few points
        source, listener = _point(p_WS), _point(p_WA)
        here, there = self.room_at(listener), self.room_at(source)
        room = self.rooms[here]
        if here == there:
            return SoundPath(room, room.clamp(p_WS))
        through = self._shortest(source, there, listener, here)
        if through is None:
            return SoundPath(room, room.clamp(p_WS), gains=(1e-3, 1e-4), late=0.0)
        points = self._pull(source, listener, through)
        whole = sum(math.dist(a, b) for a, b in itertools.pairwise(points))
        low, high, late = 1.0, 1.0, 1.0
        inside = there
        for index, number in enumerate(through):
            bent = _bent(points[index], points[index + 1], points[index + 2])
            low, high = low * bent[0], high * bent[1]
            opening = self.openings[number]
            inside = opening.beyond(inside)
            # Transfer of diffuse sound to the next room: the opening's share of its absorption
            absorbing = 0.161 * self.rooms[inside].volume_m3 / self.rooms[inside].rt60_s[0]
            late *= math.sqrt(min(1.0, opening.area_m2 / absorbing))
        last = points[-2]
        # Just inside the listener's room, so that its walls mirror it
        rest = math.dist(last, listener)
        nudge = min(_AT_DOOR_M, 0.5 * rest) / max(rest, 1e-9)
        p_W = room.clamp([a + nudge * (b - a) for a, b in zip(last, listener, strict=True)])
        before = max(0.0, whole - math.dist(_point(p_W), listener))
        return SoundPath(room, p_W, before, (low, high), late)

    def _shortest(self, source: Point, there: int, listener: Point, here: int) -> tuple[int, ...] | None:
        """Openings on the shortest way from source to listener, by their middles; None if there is none."""
        queue: list[tuple[float, int, tuple[int, ...], tuple[float, float], bool]] = [
            (0.0, there, (), source[:2], False)
        ]
        done: set[int] = set()
        while queue:
            length, room, through, at, arrived = heapq.heappop(queue)
            if arrived:
                return through
            if room == here:
                heapq.heappush(queue, (length + math.dist(at, listener[:2]), room, through, at, True))
                continue
            if room in done:
                continue
            done.add(room)
            for number in self._of[room]:
                beyond, middle = self.openings[number].beyond(room), self._middles[number]
                if beyond not in done:
                    heapq.heappush(queue, (length + math.dist(at, middle), beyond, (*through, number), middle, False))
        return None

    def _pull(self, source: Point, listener: Point, through: Sequence[int]) -> list[Point]:
        flat = [source[:2], *(self._middles[number] for number in through), listener[:2]]
        for _ in range(6 if len(through) > 1 else 1):
            for index, number in enumerate(through, 1):
                flat[index] = _cross(flat[index - 1], flat[index + 1], self.openings[number])
        along = [0.0, *itertools.accumulate(math.dist(a, b) for a, b in itertools.pairwise(flat))]
        points = [source]
        for index, number in enumerate(through, 1):
            height = source[2] + (listener[2] - source[2]) * along[index] / max(along[-1], 1e-9)
            points.append((*flat[index], min(height, self.openings[number].height - 0.05)))
        return [*points, listener]


def _point(p: NDArray[np.float64]) -> Point:
    return float(p[0]), float(p[1]), float(p[2])


def _cross(a: tuple[float, float], b: tuple[float, float], opening: Opening) -> tuple[float, float]:
    """The point of ``opening`` on the shortest way from ``a`` to ``b``: on the straight line, else at its edge."""
    (x0, y0), (x1, y1) = opening.start, opening.end
    width = math.dist(opening.start, opening.end)
    ux, uy = (x1 - x0) / width, (y1 - y0) / width
    near, far = abs((a[1] - y0) * ux - (a[0] - x0) * uy), abs((b[1] - y0) * ux - (b[0] - x0) * uy)
    at_a, at_b = (a[0] - x0) * ux + (a[1] - y0) * uy, (b[0] - x0) * ux + (b[1] - y0) * uy
    place = at_a + near / max(near + far, 1e-9) * (at_b - at_a)
    edge = min(0.1, 0.4 * width)
    place = min(max(place, edge), width - edge)
    return x0 + place * ux, y0 + place * uy


def _bent(a: Point, edge: Point, b: Point) -> tuple[float, float]:
    """Remaining amplitude, by band, after diffraction from ``a`` around ``edge`` to ``b``."""
    detour = math.dist(a, edge) + math.dist(edge, b) - math.dist(a, b)
    # Maekawa's 10 log10(3 + 20 N), without the 5 dB that it has already where the line of sight grazes the edge
    low, high = (
        10 ** (-min(10 * math.log10(1 + 40 / 3 * max(detour, 0.0) * hz / SPEED_OF_SOUND_MPS), 25.0) / 20)
        for hz in BAND_HZ
    )
    return low, high


def build(world: WorldConfig) -> Building:
    """The rooms and openings listed in ``world``; without a list, one room as large as the world."""
    listed = world.rooms or (RoomConfig.model_validate({"name": world.name, "from": (0, 0), "to": world.size}),)
    rooms = [_shoebox(world, room) for room in listed]
    openings = []
    for wall in world.walls:
        for door in wall.doors:
            openings += _opening(rooms, *_ends(wall, door), door.height)
    for gap in world.gaps:
        openings += _opening(rooms, gap.start, gap.end, world.wall_height)
    return Building(rooms, openings)


def _ends(wall: WallConfig, door: DoorConfig) -> tuple[tuple[float, float], tuple[float, float]]:
    x, y = (np.subtract(wall.end, wall.start) / wall.length_m).tolist()
    low, high = door.at - door.width / 2, door.at + door.width / 2
    (x0, y0) = wall.start
    return (x0 + x * low, y0 + y * low), (x0 + x * high, y0 + y * high)


def _opening(
    rooms: Sequence[Shoebox], start: tuple[float, float], end: tuple[float, float], height: float
) -> list[Opening]:
    """The opening between the rooms on both its sides, if there are two."""
    middle, along = np.add(start, end) / 2, np.subtract(end, start)
    normal = np.array([-along[1], along[0]]) / math.dist(start, end)
    sides = []
    for sign in (1, -1):
        place = np.array([*(middle + sign * 0.4 * normal), 1.0])
        sides.append(next((number for number, room in enumerate(rooms) if room.contains(place)), None))
    if sides[0] is None or sides[1] is None or sides[0] == sides[1]:
        return []
    return [Opening((sides[0], sides[1]), start, end, height)]


def _shoebox(world: WorldConfig, room: RoomConfig) -> Shoebox:
    x0, x1 = sorted((room.start[0], room.end[0]))
    y0, y1 = sorted((room.start[1], room.end[1]))
    size = (x1 - x0, y1 - y0, room.height or world.wall_height)
    if isinstance(room.rt60_s, tuple):
        rt60 = room.rt60_s
    elif room.rt60_s is not None:
        rt60 = (room.rt60_s, 0.8 * room.rt60_s)
    else:
        rt60 = _usual(world, (x0, y0), size)
    return Shoebox((x0, y0, 0.0), size, rt60)


def _usual(world: WorldConfig, corner: tuple[float, float], size: tuple[float, float, float]) -> tuple[float, float]:
    """Reverberation times by Sabine's formula from the size and the world's materials."""
    x, y, z = size
    floor = next((a.material for a in world.areas if _covers(a.start, a.end, corner, size)), world.floor)
    walls = [_absorption(world, wall.material) for wall in world.walls] or [np.array(ABSORPTION["plaster"])]
    swallowed = x * y * (
        _absorption(world, floor) + _absorption(world, world.ceiling or world.floor) + FURNITURE_ABSORPTION
    ) + 2 * (x + y) * z * np.mean(walls, axis=0)
    low, high = np.clip(0.161 * x * y * z / swallowed, 0.2, 2.0)
    return float(low), float(high)


def _absorption(world: WorldConfig, material: str) -> NDArray[np.float64]:
    return np.array(ABSORPTION.get(world.materials[material].pattern, ABSORPTION["plain"]))


def _covers(
    start: tuple[float, float], end: tuple[float, float], corner: tuple[float, float], size: tuple[float, float, float]
) -> bool:
    middle = (corner[0] + size[0] / 2, corner[1] + size[1] / 2)
    inside = all(min(a, b) <= m <= max(a, b) for a, b, m in zip(start, end, middle, strict=True))
    return inside and abs(end[0] - start[0]) * abs(end[1] - start[1]) > 0.5 * size[0] * size[1]

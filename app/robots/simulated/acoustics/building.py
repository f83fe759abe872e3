"""The rooms of a world and the doors between them: how a sound in one room comes to a listener in another.

Within a room sound goes straight. From another it comes through the doors, by the shortest way: the listener hears it
from the last opening, spread over the whole length, bent round every edge on its way (Z. Maekawa, "Noise reduction by
screens", Applied Acoustics 1, 1968), and some of the other room's reverberation with it. Walls let nothing through that
matters beside that (35 dB and more).
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS
from app.robots.simulated.acoustics.hearing import Way
from app.robots.simulated.acoustics.room import Shoebox
from app.robots.simulated.world_config import DoorConfig, RoomConfig, WallConfig, WorldConfig

BAND_HZ = np.array([700.0, 4000.0])
"""Middles of the two bands, for diffraction."""
#: How much of sound's energy surfaces swallow, low and high band, by pattern: after H. Kuttruff, "Room Acoustics".
ABSORPTION = {
    "plain": (0.06, 0.06), "plaster": (0.04, 0.05), "brick": (0.03, 0.05), "wood": (0.10, 0.08),
    "planks": (0.08, 0.07), "carpet": (0.20, 0.45), "tiles": (0.02, 0.03), "terrazzo": (0.02, 0.02),
    "concrete": (0.03, 0.04), "ceiling": (0.45, 0.60), "books": (0.30, 0.40), "window": (0.10, 0.04),
}  # fmt: skip
FURNITURE_ABSORPTION = 0.12
"""Of what stands in a room, per square metre of its floor."""
_AT_DOOR_M = 0.15


@dataclass(frozen=True, slots=True)
class Opening:
    """A door or a gap between two rooms (their numbers): a segment on the floor plan, ``height`` m high."""

    rooms: tuple[int, int]
    start: tuple[float, float]
    end: tuple[float, float]
    height: float

    @property
    def area_m2(self) -> float:
        """Of the opening."""
        return math.dist(self.start, self.end) * self.height

    def beyond(self, room: int) -> int:
        """The room on the other side."""
        return self.rooms[1] if self.rooms[0] == room else self.rooms[0]


class Building:
    """Rooms and openings of one world; a listener or source in none of the rooms counts to the nearest."""

    def __init__(self, rooms: Sequence[Shoebox], openings: Sequence[Opening] = ()) -> None:
        self.rooms = tuple(rooms)
        self.openings = tuple(openings)
        self._of: dict[int, list[int]] = {number: [] for number in range(len(self.rooms))}
        for number, opening in enumerate(self.openings):
            for room in opening.rooms:
                self._of[room].append(number)

    def room_at(self, p_W: NDArray[np.float64]) -> int:
        """Number of the room that holds the point, else of the nearest."""
        away = [float(np.linalg.norm(room.clamp(p_W, 0.0) - p_W)) for room in self.rooms]
        return int(np.argmin(away))

    def way(self, p_WS: NDArray[np.float64], p_WA: NDArray[np.float64]) -> Way:
        """As ``Surroundings`` says."""
        here, there = self.room_at(p_WA), self.room_at(p_WS)
        room = self.rooms[here]
        if here == there:
            return Way(room, room.clamp(p_WS))
        through = self._shortest(p_WS, there, p_WA, here)
        if through is None:
            return Way(room, room.clamp(p_WS), gains=(1e-3, 1e-4), late=0.0)
        points = self._pull(p_WS, p_WA, through)
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        gains = np.ones(2)
        late = 1.0
        inside = there
        for index, number in enumerate(through):
            gains *= _bent(points[index], points[index + 1], points[index + 2])
            opening = self.openings[number]
            inside = opening.beyond(inside)
            # What of one room's diffuse sound the next one gets: the opening's share of the absorption there
            absorbing = 0.161 * self.rooms[inside].volume_m3 / self.rooms[inside].rt60_s[0]
            late *= math.sqrt(min(1.0, opening.area_m2 / absorbing))
        last = points[-2]
        toward = points[-1] - last
        # Just inside the listener's room, so that its walls mirror it
        nudge = min(_AT_DOOR_M, 0.5 * float(np.linalg.norm(toward))) / max(float(np.linalg.norm(toward)), 1e-9)
        p_W = room.clamp(last + nudge * toward)
        before = max(0.0, float(lengths.sum()) - float(np.linalg.norm(p_W - p_WA)))
        return Way(room, p_W, before, (float(gains[0]), float(gains[1])), late)

    def _shortest(
        self, p_WS: NDArray[np.float64], there: int, p_WA: NDArray[np.float64], here: int
    ) -> tuple[int, ...] | None:
        """Openings on the shortest way from source to listener, by their middles; None if there is none."""
        queue: list[tuple[float, int, tuple[int, ...], tuple[float, float]]] = [(0.0, there, (), (p_WS[0], p_WS[1]))]
        done: set[int] = set()
        while queue:
            length, room, through, at = heapq.heappop(queue)
            if room == here:
                if through and through[-1] == -1:
                    return through[:-1]
                heapq.heappush(queue, (length + math.dist(at, (p_WA[0], p_WA[1])), room, (*through, -1), at))
                continue
            if room in done:
                continue
            done.add(room)
            for number in self._of[room]:
                opening = self.openings[number]
                beyond = opening.beyond(room)
                middle = ((opening.start[0] + opening.end[0]) / 2, (opening.start[1] + opening.end[1]) / 2)
                if beyond not in done:
                    heapq.heappush(queue, (length + math.dist(at, middle), beyond, (*through, number), middle))
        return None

    def _pull(
        self, p_WS: NDArray[np.float64], p_WA: NDArray[np.float64], through: Sequence[int]
    ) -> NDArray[np.float64]:
        """The way (n, 3) drawn taut through the openings."""
        middles = [np.add(self.openings[n].start, self.openings[n].end) / 2 for n in through]
        flat = np.array([p_WS[:2], *middles, p_WA[:2]])
        for _ in range(8 if len(through) > 1 else 1):
            for index, number in enumerate(through, 1):
                flat[index] = _cross(flat[index - 1], flat[index + 1], self.openings[number])
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flat, axis=0), axis=1))])
        height = p_WS[2] + (p_WA[2] - p_WS[2]) * along / max(float(along[-1]), 1e-9)
        for index, number in enumerate(through, 1):
            height[index] = min(height[index], self.openings[number].height - 0.05)
        return np.column_stack([flat, height])


def _cross(a: NDArray[np.float64], b: NDArray[np.float64], opening: Opening) -> NDArray[np.float64]:
    """The point of ``opening`` on the shortest way from ``a`` to ``b`` (2,): on the straight line, else at its edge."""
    start, along = np.array(opening.start), np.subtract(opening.end, opening.start)
    width = float(np.linalg.norm(along))
    unit = along / width
    normal = np.array([-unit[1], unit[0]])
    near, far = float((a - start) @ normal), float((b - start) @ normal)
    at_a, at_b = float((a - start) @ unit), float((b - start) @ unit)
    share = abs(near) / max(abs(near) + abs(far), 1e-9)
    place = at_a + share * (at_b - at_a)
    edge = min(0.1, 0.4 * width)
    crossed: NDArray[np.float64] = start + unit * min(max(place, edge), width - edge)
    return crossed


def _bent(a: NDArray[np.float64], edge: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """What is left of amplitude (2,), by band, after going from ``a`` round ``edge`` to ``b``."""
    detour = float(np.linalg.norm(edge - a) + np.linalg.norm(b - edge) - np.linalg.norm(b - a))
    fresnel = 2 * detour * BAND_HZ / SPEED_OF_SOUND_MPS
    # Maekawa's 10 log10(3 + 20 N), without the 5 dB that it has already where the line of sight grazes the edge
    lost_db = np.minimum(10 * np.log10(1 + 20 / 3 * fresnel), 25.0)
    left: NDArray[np.float64] = 10 ** (-lost_db / 20)
    return left


def build(world: WorldConfig) -> Building:
    """The rooms and openings that ``world`` lists; without a list, one room as large as the world."""
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
    """Reverberation times by Sabine from the size and the world's materials."""
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

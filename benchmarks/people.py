"""Persons among four people in the simulated lab: who is where, whether each keeps one identity, and who speaks.

The scene is perceived once; the tracker then goes through it with all it can use, and without each. Faces and voices
are drawn from measured figures (``people_percepts.py``, two minutes of CPU), or, with ``HBBA_PEOPLE=perceived``,
perceived in rendered pictures and sound (``people_scene.py``, a quarter of an hour). ``HBBA_PEOPLE_RECORDING=FILE``
keeps what was perceived, and takes it from there the next time; ``HBBA_PEOPLE_SEED`` draws other waits and speeds. A
person is *in view* within 6 m ahead of the laser with nothing between; *overall* are all four all the time, also in
other rooms. Found is what is within 1 m.
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from app.robots.simulated.gl import gl_environment

os.environ.update(gl_environment())  # read when MuJoCo is imported

import numpy as np

from app.base.geometry import Pose2
from app.base.pose_buffer import PoseBuffer
from app.messages import Faces, LaserScan, Localization, OccupancyGrid, Odometry, Person, Persons, SoundSources
from app.modules.perception.people.identities import IdentityRules
from app.modules.perception.people.legs import legs_seen
from app.modules.perception.people.observations import Walls, faces_seen, voices_heard
from app.modules.perception.people.person_tracks import PersonTracks
from app.modules.perception.people.torso_color import histogram
from app.modules.perception.people.torso_places import torso_places
from app.modules.perception.people.values import PersonRules
from benchmarks.people_percepts import model
from benchmarks.people_scene import Picture, Torsos, Truth, Worn, record, recorded
from benchmarks.report import Row, benchmark_main, row
from benchmarks.tracking_metrics import Frame, Hypothesis, Point, Scores, matched, score

BENCHMARK = "people"
WITHIN_M, VIEW_M, LEGS_M = 1.0, 6.0, 8.0
#: Every so many instants of the truth are scored: 5 a second.
EVERY = 4
#: ``perceived``: the whole program perceives the scene.
SCENE = "HBBA_PEOPLE"
#: The file in which the scene is kept, and from which it is taken when it is there; and the scene's seed.
RECORDING, SEED = "HBBA_PEOPLE_RECORDING", "HBBA_PEOPLE_SEED"


@dataclass(frozen=True, slots=True)
class Uses:
    """What the tracker is given."""

    faces: bool = True
    legs: bool = True
    colors: bool = True


@dataclass(frozen=True, slots=True)
class Sentence:
    """One sentence: how often its speaker was in view, and how often who was thought to speak."""

    person: str
    instants: int
    in_view: int
    thought: Counter[str]


@dataclass(frozen=True, slots=True)
class Outcome:
    """The scores in view and overall, the sentences, and CPU time of the tracker (ms for each second)."""

    in_view: Scores
    overall: Scores
    sentences: tuple[Sentence, ...]
    cpu_ms_per_s: float


def judge(messages: Sequence[object], uses: Uses) -> Outcome:
    """The tracker on a recorded scene."""
    poses = PoseBuffer(span_s=math.inf)
    for message in messages:
        if isinstance(message, Odometry):
            poses.add(message.stamp, message.X_OB)
    tracks = PersonTracks(rules=PersonRules(identity=IdentityRules(colors=uses.colors)))
    walls: Walls | None = None
    grid: OccupancyGrid | None = None
    X_MO: Pose2 | None = None
    scan: LaserScan | None = None
    faces: set[int] = set()
    viewed: list[Frame] = []
    everywhere: list[Frame] = []
    sentences: dict[str, Sentence] = {}
    before: dict[str, int] = {}
    cpu_s, count, begin, end = 0.0, 0, math.inf, 0.0
    for message in messages:
        began = time.thread_time()
        match message:
            case OccupancyGrid():
                grid = message
            case Localization():
                X_MO = message.X_MO
            case Faces() if uses.faces and (X_OB := poses.at(message.stamp)):
                faces = {face.track for face in message.faces}
                tracks.see_faces(message.stamp, faces_seen(message, X_OB))
            case Torsos() if uses.colors and uses.faces:
                tracks.see_torsos(message.stamp, {f: histogram(pixels) for f, pixels in message.pixels.items()})
            case Picture() | Worn() if uses.colors and uses.faces and uses.legs and (X_OB := poses.at(message.stamp)):
                around = Persons(message.stamp, tracks.persons(message.stamp))
                at = torso_places(around, message.stamp, faces, (X_OB, message.X_BC), message.measured)
                looked = time.thread_time()
                pixels = message.torsos(at) if at else {}
                # The program has the picture before it, and decodes none.
                cpu_s -= time.thread_time() - looked
                tracks.see_worn(message.stamp, {track: histogram(found) for track, found in pixels.items()})
            case LaserScan():
                scan = message
                if uses.legs and (X_OB := poses.at(message.stamp)):
                    tracks.see_legs(message.stamp, legs_seen(message, X_OB, LEGS_M, grid, X_MO))
            case SoundSources() if X_OB := poses.at(message.stamp):
                tracks.hear(message.stamp, *voices_heard(message, X_OB))
        if isinstance(message, OccupancyGrid | Localization) and grid is not None and X_MO is not None:
            walls = Walls(grid, X_MO)
            tracks.passable = walls.passable
        cpu_s += time.thread_time() - began
        if not isinstance(message, Truth):
            continue
        count += 1
        X_OB = poses.at(message.stamp)
        if count % EVERY or scan is None or X_OB is None:
            continue
        begin, end = min(begin, message.stamp), max(end, message.stamp)
        persons = [p for p in tracks.persons(message.stamp) if p.state in ("confirmed", "unsure")]
        found = [_hypothesis(person, X_OB) for person in persons]
        truth = {p.name: _in_base((p.x, p.y), message.X_WB) for p in message.people}
        seen = {name for name, at in truth.items() if in_view(at, scan)}
        hidden = {name: at for name, at in truth.items() if name not in seen}
        viewed.append(Frame({name: truth[name] for name in seen}, found, hidden))
        everywhere.append(Frame(truth, found))
        pairs, _ = matched(everywhere[-1], before, WITHIN_M)
        before = {name: each.track for name, each in pairs.items()}
        names = {each.track: name for name, each in pairs.items()}
        thought = [names.get(person.track, "nobody there") for person in persons if person.speaking]
        for person, sentence in message.talking.items():
            held = sentences.get(sentence, Sentence(person, 0, 0, Counter()))
            sentences[sentence] = replace(
                held,
                instants=held.instants + 1,
                in_view=held.in_view + (person in seen),
                # Others who talk at the same time may be heard, too.
                thought=held.thought + Counter(n for n in thought if n == person or n not in message.talking),
            )
    seconds = max(end - begin, 1e-9)
    return Outcome(
        score(viewed, WITHIN_M), score(everywhere, WITHIN_M), tuple(sentences.values()), 1000 * cpu_s / seconds
    )


def in_view(p_B: Point, scan: LaserScan) -> bool:
    """Whether the laser reaches a person at ``p_B`` (m in ``base_link``) within ``VIEW_M``."""
    p_L = scan.X_BL.inverse().transform(np.array([*p_B, 0.0]))
    away, towards = math.hypot(p_L[0], p_L[1]), math.atan2(p_L[1], p_L[0])
    if not 0.3 < away <= VIEW_M:
        return False
    aside = math.atan2(0.15, away)
    first, last = (round((towards + turn - scan.angle_min) / scan.angle_increment) for turn in (-aside, aside))
    ranges = scan.ranges[max(first, 0) : max(last + 1, 0)]
    return bool(ranges.size and np.median(ranges) >= away - 0.4)


def _hypothesis(person: Person, X_OB: Pose2) -> Hypothesis:
    x, y = _in_base(person.p_OP[:2], X_OB)
    return Hypothesis(person.track, person.person, (x, y))


def _in_base(at: Point, X_RB: Pose2) -> Point:
    x, y = X_RB.inverse().transform(np.array(at, np.float64)).tolist()
    return x, y


def speaker_right(sentences: Iterable[Sentence]) -> tuple[int, int, int]:
    """Of the sentences of people in view: how many, of how many of these the speaker is right, and wrong.

    Neither where nobody was thought to speak for a tenth of it.
    """
    total = right = wrong = 0
    for sentence in sentences:
        if sentence.in_view < 0.5 * sentence.instants:
            continue
        total += 1
        if sentence.thought.total() < 0.1 * sentence.instants:
            continue
        best = sentence.thought.most_common(1)[0][0]
        right += best == sentence.person
        wrong += best != sentence.person
    return total, right, wrong


CASES = {
    "all": Uses(),
    "without colours": Uses(colors=False),
    "without legs": Uses(legs=False),
    "without faces": Uses(faces=False, colors=False),
}


def measure(quick: bool) -> list[Row]:
    """The rows of all cases; ten minutes of the scene, in quick half a minute."""
    perceive = record if os.environ.get(SCENE) == "perceived" else model
    with tempfile.TemporaryDirectory() as folder:
        path = Path(os.environ.get(RECORDING) or Path(folder) / "scene.pickle")
        if not path.exists():
            perceive(30.0 if quick else 600.0, path, int(os.environ.get(SEED, "1")))
        messages = list(recorded(path))
    rows = []
    for case, uses in CASES.items():
        outcome = judge(messages, uses)
        print(case, outcome, file=sys.stderr, flush=True)
        rows += _rows(case, outcome)
    return rows


def _rows(case: str, outcome: Outcome) -> list[Row]:
    rows = []
    for where, scores in (("in view", outcome.in_view), ("overall", outcome.overall)):
        figures = {
            ("MOTA", "%"): 100 * scores.mota,
            ("IDF1", "%"): 100 * scores.idf1,
            ("distance", "m"): scores.motp_m,
            ("swaps", ""): scores.swaps,
            ("identities", "of 4"): scores.identities,
            ("unsure", "% of the time found"): 100 * scores.unsure,
            ("missed", "%"): 100 * scores.misses / max(scores.objects, 1),
            ("false", "%"): 100 * scores.false / max(scores.objects, 1),
        }
        rows += [row(BENCHMARK, f"{case}, {where}", metric, unit, [v]) for (metric, unit), v in figures.items()]
    total, right, wrong = speaker_right(outcome.sentences)
    rows.append(row(BENCHMARK, case, "sentences with the right speaker", f"of {total}", [right]))
    rows.append(row(BENCHMARK, case, "... with a wrong one", f"of {total}", [wrong]))
    rows.append(row(BENCHMARK, case, "CPU of the tracker", "ms/s", [outcome.cpu_ms_per_s]))
    return rows


if __name__ == "__main__":
    raise SystemExit(benchmark_main(__doc__, measure))

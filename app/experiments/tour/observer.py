"""Notes of a tour under way, by the truth of its world: what the guide, the voice, an arm and the visitors did."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any, Protocol

import numpy as np

from app.attention.intention import Intention
from app.base.geometry import FloatArray, Pose2, wrap_angle
from app.base.kinematic_model import KinematicModel, load_model
from app.experiments.goals.result import clearance
from app.experiments.tour.result import Arrival, SaidText, Sample
from app.link import RobotDescription
from app.messages import Accomplishment, JointState, PersonTruth, Place, Speech, TourProgress
from app.program.system import System
from app.robots.simulated.scenery.people import TRUNK_RADIUS_SHARE
from app.tours.model import Tour

#: What is said in these states asks something of people, and is cut short, for this reason, as they do it.
_CUT_SHORT = {
    "confirming": "visitors answered",
    "leading": "the way is free",
    "waiting": "visitors have come",
    "searching": "visitors are found",
    "blocked": "it was answered",
}


class TrueBody(Protocol):
    """A body whose world says the truth."""

    @property
    def description(self) -> RobotDescription: ...

    @property
    def people(self) -> Sequence[PersonTruth]: ...

    def true_pose(self) -> Pose2: ...


class TourObserver:
    """Notes of ``tour`` on the map at ``X_WM`` in the world, which has ``places``; a context manager."""

    def __init__(self, system: System, body: TrueBody, tour: Tour, places: Mapping[str, Place], X_WM: Pose2) -> None:
        self._system = system
        self._body = body
        self._tour = tour
        self._places = places
        self._X_MW = X_WM.inverse()
        self._model = load_model(body.description.model_path)
        self._begin = system.clock.now()
        self._stack = ExitStack()
        self._joints: dict[str, float] = {}
        #: First sentence of each text under way, and the state in which it began, by its desire.
        self._saying: dict[str, tuple[str, str]] = {}
        self.samples: list[Sample] = []
        self.arrivals: list[Arrival] = []
        self.texts: list[SaidText] = []
        self.sentences: set[str] = set()
        self.pointed_deg: list[float] = []
        self.progress: TourProgress | None = None
        self.answered = 0
        self.has_run = False
        self.cpu_share = 0.0
        self.people_m: float | None = None

    def __enter__(self) -> TourObserver:
        takers: dict[type[Any], Callable[[Any], None]] = {
            Speech: self._speech,
            TourProgress: self._guide,
            Accomplishment: self._accomplished,
            JointState: self._move,
        }
        for channel in self._system.graph.channels.values():
            if (take := takers.get(channel.message_type)) is not None:
                self._stack.callback(channel.observe(take))
        self._stack.callback(self._system.translator.observe(self._intend))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def elapsed_s(self) -> float:
        """Since the begin (s)."""
        return self._system.clock.now() - self._begin

    @property
    def has_ended(self) -> bool:
        """Whether a tour was under way and is no more."""
        return self.has_run and self.progress is not None and self.progress.state == "idle"

    def look(self) -> None:
        """Note where all are; to be called a few times a second."""
        pose, people = self._pose(), self._body.people
        places = tuple(self._X_MW @ Pose2(person.x, person.y) for person in people)
        state = "idle" if self.progress is None else self.progress.state
        robot = (round(pose.x, 3), round(pose.y, 3), round(pose.theta, 3))
        self.samples.append(
            Sample(round(self.elapsed_s, 2), robot, tuple((round(at.x, 2), round(at.y, 2)) for at in places), state)
        )
        for person, at in zip(people, places, strict=True):
            beside = pose.inverse() @ at
            radius_m = TRUNK_RADIUS_SHARE * person.height_m
            room = clearance(self._body.description.footprint, beside.x, beside.y, radius_m)
            self.people_m = room if self.people_m is None else min(self.people_m, room)

    def _pose(self) -> Pose2:
        return self._X_MW @ self._body.true_pose()

    def _guide(self, progress: TourProgress) -> None:
        before, self.progress = self.progress, progress
        if progress.state != "idle":
            self.has_run = True
        if before is None or before.state == progress.state:
            return
        self.answered += before.state == "answering" and progress.state == "listening"
        if before.state == "leading" and progress.state in ("turning", "presenting"):
            pose = self._pose()
            stop = next(each for each in self._tour.stops if each.id == progress.stop)
            place = self._places[stop.place]
            off_m = math.hypot(pose.x - place.x, pose.y - place.y)
            self.arrivals.append(Arrival(stop.id, round(off_m, 3), round(wrap_angle(pose.theta - place.heading), 3)))

    def _speech(self, speech: Speech) -> None:
        if speech.state == "speaking":
            self.sentences.add(speech.text)
        for desire in [each for each in self._saying if each != speech.desire]:
            # No report came before the next text, or silence.
            text, state = self._saying.pop(desire)
            reason = "" if self.progress is None else self.progress.reason
            self.texts.append(SaidText(text, ended=False, reason=reason or _CUT_SHORT.get(state, "")))
        if speech.state == "speaking" and speech.desire:
            state = "" if self.progress is None else self.progress.state
            self._saying.setdefault(speech.desire, (speech.text, state))

    def _accomplished(self, report: Accomplishment) -> None:
        said = self._saying.pop(report.desire_id, None)
        if said is not None:
            self.texts.append(SaidText(said[0], ended=report.outcome == "done", reason=report.reason))
        if report.behavior == "PointAt" and report.outcome == "done" and (target := self._target()) is not None:
            self.pointed_deg.append(round(self._off_deg(target), 1))

    def _target(self) -> tuple[float, float, float] | None:
        """The point on the map of the step that is under way."""
        if self.progress is None or not self.progress.step:
            return None
        stop = next((each for each in self._tour.stops if each.id == self.progress.stop), None)
        return None if stop is None else stop.do[self.progress.step - 1].point

    def _off_deg(self, target: tuple[float, float, float]) -> float:
        """How far off (degrees) the arm that points best is."""
        at = self._pose().inverse() @ Pose2(*target[:2])
        p_BP = np.array([at.x, at.y, target[2]])
        arms = self._body.description.arms.values()
        groups = self._body.description.groups
        lines = [(groups[arm.group].joints[0].name, arm.hand) for arm in arms]
        return min(off_deg(self._model, self._joints, line, p_BP) for line in lines)

    def _move(self, joints: JointState) -> None:
        self._joints = dict(zip(joints.names, joints.positions, strict=True))

    def _intend(self, intention: Intention) -> None:
        used = sum(strategy.costs.get("cpu", 0.0) for strategy in intention.strategies)
        if capacity := intention.capacities.get("cpu"):
            self.cpu_share = max(self.cpu_share, used / capacity)


def off_deg(model: KinematicModel, joints: Mapping[str, float], line: tuple[str, str], p_BP: FloatArray) -> float:
    """The angle (degrees) at the shoulder between an arm and the point ``p_BP`` (3,) m in the root link. ``line``: the
    joint of the shoulder, and the link of the hand."""
    shoulder, hand = model.joints[line[0]].child, line[1]
    poses = model.poses((shoulder, hand), joints)
    p_BS = poses[shoulder].translation
    arm, wanted = poses[hand].translation - p_BS, p_BP - p_BS
    cosine = float(arm @ wanted) / (float(np.linalg.norm(arm)) * float(np.linalg.norm(wanted)))
    return math.degrees(math.acos(min(max(cosine, -1.0), 1.0)))

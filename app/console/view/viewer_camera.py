"""The camera of one viewer: glides to the viewpoint that was chosen, and lets go of it when its user takes it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import viser

from app.base.geometry import Pose2, wrap_angle
from app.console.view.picking import Ray, ray_through
from app.console.view.viewpoints import FIRST, Anchors, Choice, Glide, Shot, Viewpoint, shot, shot_of, stage_of

#: What differs by less (m, and share of the distance) is there.
_THERE_M, _THERE_SHARE = 0.02, 0.01


@dataclass(frozen=True, slots=True)
class CameraState:
    """What a viewer sees from: ``arrived`` once its browser says so; ``bearing`` and ``gaze``: azimuths (rad) of its
    view and of the robot's camera in ``base_link``."""

    viewpoint: Viewpoint
    number: int
    arrived: bool
    bearing: float
    gaze: float = 0.0


class ViewerCamera:
    """For the painter's thread; the browser's camera messages come in viser's."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._viewpoint: Viewpoint = FIRST
        self._number = 0
        self._grabs = 0
        self._glide: Glide | None = None
        #: ``X_TS``: the stage in the viewpoint's own; not the identity after a glide that was not finished.
        self._offset = Pose2()
        self._kept_heading: float | None = None
        self._arrived = False
        self._X_OS = Pose2()
        self._bearing = self._gaze = 0.0

        # A browser is known from its first word on, which has its camera, and says no more before that moves.
        self._take(client.camera)
        client.camera.on_update(self._take)

    def _take(self, camera: viser.CameraHandle) -> None:
        """Where the browser says that its camera is."""
        self._seen: Shot = shot_of(camera.position, camera.look_at, camera.fov)
        self._aspect = camera.aspect

    @property
    def state(self) -> CameraState:
        bearing, gaze = round(self._bearing, 3), round(self._gaze, 3)
        return CameraState(self._viewpoint, self._number, self._arrived, bearing=bearing, gaze=gaze)

    def ray(self, u: float, v: float) -> Ray:
        """What it sees at shares (0 to 1) of its picture's width from the left and height from the top: a ray of O."""
        return ray_through(self._seen, self._aspect, u, v).in_frame(self._X_OS)

    @property
    def viewpoint(self) -> Viewpoint:
        """The one that was chosen last."""
        return self._viewpoint

    @property
    def inside(self) -> bool:
        """Whether it is where the robot's camera is: inside of the robot's head."""
        return self._viewpoint == "first_person" and self._glide is None

    def moving(self, choice: Choice) -> bool:
        """Whether it glides, or should begin to."""
        return self._glide is not None or choice.number != self._number

    def step(self, choice: Choice, anchors: Anchors, now: float) -> Pose2:
        """Go on, at ``now`` (s); returns where the stage is, ``X_OS``."""
        if self._kept_heading is None:
            self._kept_heading = anchors.X_OB.theta
        anchors = replace(anchors, kept_heading=self._kept_heading, aspect=self._aspect)
        if choice.number != self._number:
            anchors = self._begin(choice, anchors, now)
        elif choice.grabs != self._grabs and self._glide is not None:
            self._offset = self._glide.offset.interpolate(Pose2(), self._glide.share(now))
            self._glide = None
        self._grabs = choice.grabs
        if self._glide is not None and self._glide.hold != choice.hold:
            self._glide = replace(self._glide, hold=choice.hold)
        if self._glide is None:
            self._X_OS = stage_of(self._viewpoint, anchors) @ self._offset
        else:
            self._X_OS = self._glide.stage(now, anchors)
            self._point(self._glide.shot(now, anchors))
            if self._glide.share(now) >= 1.0:
                self._glide, self._offset = None, Pose2()
        seen = self._seen
        self._gaze = anchors.gaze[0]
        self._bearing = wrap_angle(self._X_OS.theta + seen.heading - anchors.X_OB.theta)
        if self._glide is None and not self._arrived:
            self._arrived = _there(seen, shot(self._viewpoint, anchors))
        return self._X_OS

    def _begin(self, choice: Choice, anchors: Anchors, now: float) -> Anchors:
        begin = self._seen if self._glide is None else self._glide.shot(now, anchors)
        self._viewpoint, self._number, self._arrived = choice.viewpoint, choice.number, False
        if choice.viewpoint == "free":
            self._kept_heading = self._X_OS.theta
        elif choice.viewpoint == "map":
            self._kept_heading = 0.0
        assert self._kept_heading is not None
        anchors = replace(anchors, kept_heading=self._kept_heading)
        offset = stage_of(choice.viewpoint, anchors).inverse() @ self._X_OS
        self._glide = Glide(choice.viewpoint, now, begin, offset)
        return anchors

    def _point(self, at: Shot) -> None:
        camera = self._client.camera
        # The position first: viser moves what it looks at along with it.
        camera.position = np.array(at.eye)
        camera.look_at = np.array(at.target)
        camera.fov = at.fov


def _there(seen: Shot, wanted: Shot) -> bool:
    apart = max(math.dist(seen.eye, wanted.eye), math.dist(seen.target, wanted.target))
    return apart <= _THERE_M + _THERE_SHARE * wanted.distance

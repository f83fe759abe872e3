"""FaceDetector: detection, position and tracking of faces (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────────┐
    │ FaceDetector   in   images     Image with depth, 15 Hz / φ                                   │
    │                in   panorama   Image of the fisheye, 10 Hz / φ                               │
    │                in   odometry   Odometry, 100 Hz, X_OB in odom; never filtered                │
    │                in   persons    Persons: above whose legs to look for colours; optional       │
    │                out  faces      Faces, with each image taken, px and m in base_link           │
    │                out  torsos     TorsoColors, with each image in which there are any           │
    │                out  confidence Confidence, by how bright the images are                      │
    └─────────────────────────────────────────────────────────────────────────────────────────────┘

Detects faces with YuNet, in the fisheye's image after unrolling (``faces/yunet.py``, ``faces/panorama.py``). Positions
come from depth, or without depth from the direction and the distribution of people's heights
(``faces/face_position.py``, ``height_prior.py``). Each face has a track number for as long as it is visible in either
camera (``faces/face_tracks.py``). Both cameras are optional, and either may be closed. The colours below the faces, and
above the legs of persons who show none, are given out for recognizing persons, where something wants them
(``people/torso_color.py``, ``people/torso_places.py``).

``min_score`` is a parameter of the desire LocateFaces. ``fine`` is a parameter of its strategies: without it images are
reduced first, which takes a third of the CPU time and halves the range of detection.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.messages import Confidence, Face, Faces, Image, Odometry, Persons, TorsoColors, read_only
from app.modules.perception.faces.face_position import FaceLocator, FaceSighting
from app.modules.perception.faces.face_tracks import FaceTracks, TrackedFace, TrackModel, prepare
from app.modules.perception.faces.yunet import THRESHOLD
from app.modules.perception.height_prior import HeightPrior
from app.modules.perception.opencv import use_calling_thread
from app.modules.perception.people.torso_color import BINS, LEGS_ASIDE_M, histogram, torso_pixels
from app.modules.perception.people.torso_places import torso_places
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.working_conditions import LightReporter
from app.runtime.module import Module, ModuleContext, Settings

#: Kept over restarts, so that track numbers are not reused.
_NEXT_TRACK = "next track"
#: Persons of so long (s) before or after an image say where torsos are in it.
_PERSONS_S = 0.3


class FaceDetectorSettings(Settings):
    min_score: float = Field(THRESHOLD, gt=0, lt=1, description="used while no desire says another")
    fine: bool = Field(True, description="used while no strategy says another")
    fine_px: int = Field(640, ge=64, le=4096, description="longest side of images without fisheye, looked at finely")
    coarse_px: int = Field(320, ge=64, le=4096, description="... and otherwise")
    fine_px_per_rad: float = Field(400, ge=50, le=2000, description="of the fisheye's image unrolled, finely")
    coarse_px_per_rad: float = Field(244, ge=50, le=2000, description="... and otherwise")
    height_mean_m: float = Field(1.71, gt=0, description="mean height of the people expected, shoes on")
    height_sigma_m: float = Field(0.10, gt=0, description="its standard deviation")
    forget_s: float = Field(1.2, gt=0, description="a face not seen for longer has gone, and comes back as another")


class LocateFacesParameters(BaseModel, extra="forbid", title="Locate faces"):
    min_score: float = Field(
        0.8,
        gt=0,
        lt=1,
        title="Least score",
        description="How sure the detector must be that it is a face, 0 to 1: higher loses small and turned faces, "
        "lower takes other things for faces.",
    )


LOCATE_FACES = DesireClass(
    name="LocateFaces",
    title="Locate faces",
    description="Find faces in both cameras' views, follow them, and report where they are (m, in base_link).",
    parameters=LocateFacesParameters,
)


class FaceDetector(Module):
    title = "Face detector"
    desire_classes = (LOCATE_FACES,)
    runs_elsewhere = True
    Settings = FaceDetectorSettings
    settings: FaceDetectorSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._min_score = self.settings.min_score
        self._fine = self.settings.fine
        self._looker: FaceLocator | None = None
        self._tracks = FaceTracks()
        self._persons: Persons | None = None
        self._poses = PoseAt(self.clock, self.log, "faces are followed by their place in the image alone")
        self.images = self.input("images", Image)
        self.panorama = self.input("panorama", Image)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True, rests=True)
        self.persons = self.input("persons", Persons, always_open=True, wants="never", rests=True)
        self.faces = self.output("faces", Faces)
        self.torsos = self.output("torsos", TorsoColors)
        self.confidence = self.output("confidence", Confidence)
        self._light = LightReporter(self.confidence)
        self.on(self.images, self._detect)
        self.on(self.panorama, self._detect)
        self.on(self.odometry, self._poses.add)
        self.on(self.persons, self._note_persons)

    async def start(self) -> None:
        """Load the model; after a restart, continue with unused track numbers. Raises ModuleFailed."""
        use_calling_thread()
        people = HeightPrior(self.settings.height_mean_m, self.settings.height_sigma_m)
        self._looker = await self.compute(FaceLocator, self._min_score, people)
        await self.compute(prepare)
        self._tracks = FaceTracks(TrackModel(forget_s=self.settings.forget_s), self.persistent.get(_NEXT_TRACK, 1))

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._min_score = float(parameters.get("min_score", self.settings.min_score))
        self._fine = bool(parameters.get("fine", self.settings.fine))

    async def _detect(self, image: Image) -> None:
        self._light.look(image)
        sightings = await self.compute(self._find, image, self._min_score, self._fine)
        X_OB = await self._poses.logged_at(image.stamp) if sightings else None
        # The same module on another computer may have given numbers meanwhile.
        self._tracks.next = max(self._tracks.next, self.persistent.get(_NEXT_TRACK, 1))
        placed = self._tracks.see(image.stamp, image.frame, sightings, None if X_OB is None else X_OB.to_pose3())
        self.persistent[_NEXT_TRACK] = self._tracks.next
        faces = tuple(_face(sighting, where) for sighting, where in zip(sightings, placed, strict=True))
        height, width = image.color.shape[:2]
        self.faces.publish(Faces(image.stamp, image.frame, width=width, height=height, X_BC=image.X_BC, faces=faces))
        if self.torsos.wanted:
            places = await self._torso_places(image, faces)
            if faces or places:
                colors = await self.compute(_torso_colors, image, faces, places)
                if len(colors.histograms):
                    self.torsos.publish(colors)

    async def _torso_places(self, image: Image, faces: tuple[Face, ...]) -> dict[int, tuple[float, float, float]]:
        persons = self._persons
        if persons is None or not persons.persons or abs(image.stamp - persons.stamp) > _PERSONS_S:
            return {}
        X_OB = await self._poses.logged_at(image.stamp)
        if X_OB is None:
            return {}
        tracks = {face.track for face in faces}
        return torso_places(persons, image.stamp, tracks, (X_OB, image.X_BC), measured=image.depth is not None)

    def _note_persons(self, persons: Persons) -> None:
        self._persons = persons

    def _find(self, image: Image, min_score: float, fine: bool) -> list[FaceSighting]:
        assert self._looker is not None
        settings = self.settings
        self._looker.finder.threshold = min_score
        longest = settings.fine_px if fine else settings.coarse_px
        return self._looker.look(image, longest, settings.fine_px_per_rad if fine else settings.coarse_px_per_rad)


def _torso_colors(
    image: Image, faces: tuple[Face, ...], places: Mapping[int, tuple[float, float, float]]
) -> TorsoColors:
    below = {face.track: torso_pixels(image, face.p_BF) for face in faces}
    above = {track: torso_pixels(image, place, LEGS_ASIDE_M) for track, place in places.items()}
    by_face, by_legs = (
        {track: histogram(pixels) for track, pixels in found.items() if pixels is not None} for found in (below, above)
    )
    rows = np.array([*by_face.values(), *by_legs.values()], np.float32).reshape(-1, BINS)
    return TorsoColors(image.stamp, image.frame, tuple(by_face), read_only(rows), tuple(by_legs))


def _face(sighting: FaceSighting, placed: TrackedFace) -> Face:
    x, y, z = placed.p_BF.tolist()
    towards = placed.p_BF - sighting.origin
    range_m = float(np.linalg.norm(towards))
    ray = towards / range_m
    return Face(
        placed.track,
        sighting.face.score,
        box=sighting.face.box,
        landmarks=read_only(sighting.face.landmarks),
        p_BF=(x, y, z),
        covariance=read_only(placed.covariance),
        range_m=range_m,
        range_sigma_m=float(np.sqrt(ray @ placed.covariance @ ray)),
    )

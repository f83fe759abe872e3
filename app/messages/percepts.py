"""Messages of perceptions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Final

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.messages.base import PerceptKind

#: JSON Schema of a row of cells.
CELLS: dict[str, Any] = {"type": "array", "items": {"type": "integer", "minimum": 0, "maximum": 255}}
#: JSON Schema of a row of an array of points.
POINT: dict[str, Any] = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}


@dataclass(frozen=True, slots=True, eq=False)
class QRCode:
    """One decoded code: ``corners`` (4, 2) float32 px, from the code's upper left, clockwise as printed.

    ``p_BQ`` is its centre in ``base_link`` at the message's stamp, None where it could not be measured. ``n_BQ`` is the
    unit vector of its outward normal there, towards whom it is read by, with standard deviation ``normal_sigma`` (rad);
    both None where the surface it hangs on could not be measured.
    """

    text: str
    corners: NDArray[np.float32]
    p_BQ: tuple[float, float, float] | None
    n_BQ: tuple[float, float, float] | None = None
    normal_sigma: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class QRCodes:
    """All codes of one image (possibly none), ``frame`` being the camera's name.

    The image is ``width`` x ``height`` px; ``X_BC`` is the camera's pose in ``base_link`` at ``stamp``.
    """

    stamp: float
    frame: str
    width: int
    height: int
    X_BC: Pose3
    codes: tuple[QRCode, ...]


@dataclass(frozen=True, slots=True)
class Landmark:
    """A code that hangs somewhere: its sightings, fused.

    ``p_FQ`` is its centre (m) in the frame F of :class:`Landmarks`, ``sigma_m`` the standard deviation along each
    axis. ``heading`` is the direction in F (rad, in [-pi, pi[) of the horizontal part of the code's outward normal, the
    side it is read from, with standard deviation ``heading_sigma`` (rad); both None while unknown. ``first_seen`` and
    ``last_seen`` are stamps of images. ``id`` is a number from 1 that it keeps on its map; the same text may hang in
    several places.
    """

    text: str
    p_FQ: tuple[float, float, float]
    sigma_m: float
    sightings: int
    first_seen: float
    last_seen: float
    heading: float | None = None
    heading_sigma: float | None = None
    id: int = 0


@dataclass(frozen=True, slots=True)
class Landmarks:
    """Every landmark known so far, in the order of first sight; published when one is added, moves or is removed.

    ``frame`` F is ``map`` once the robot has been localized on the map in use, and ``odom`` without a map.
    """

    stamp: float
    landmarks: tuple[Landmark, ...]
    frame: str = "odom"


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud:
    """Coloured points of one depth image.

    ``points`` (N, 3) float32, m in ``base_link`` at ``stamp``; ``colors`` (N, 3) uint8, RGB.

    ``X_OB`` is the pose of that ``base_link`` in ``odom`` at the same ``stamp``: drawn with it, a cloud stays where
    it was seen however late it comes (thesis 3.4: the cloud was drawn with a newer head pose than its own).
    """

    stamp: float
    points: NDArray[np.float32]
    colors: NDArray[np.uint8]
    X_OB: Pose2


@dataclass(frozen=True, slots=True)
class EncodedImage:
    """A JPEG of a camera's image for people to look at, ``width`` x ``height`` px.

    ``X_BC`` is the camera's pose in ``base_link`` at ``stamp``.
    """

    stamp: float
    frame: str
    jpeg: bytes
    width: int
    height: int
    X_BC: Pose3


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """One face in one image.

    ``track`` keeps its number while the face stays in view, over frames and over both cameras; ``score`` in [0, 1].
    ``box`` is left, top, width, height (px); ``landmarks`` (5, 2) float32 px: right eye, left eye, nose, right and left
    corner of the mouth (the person's right). ``p_BF`` is the middle of the face in ``base_link`` at the message's stamp
    and ``covariance`` (3, 3) float64 its, m^2; ``range_m`` from the camera with standard deviation ``range_sigma_m``.
    """

    track: int
    score: float
    box: tuple[float, float, float, float]
    landmarks: NDArray[np.float32]
    p_BF: tuple[float, float, float]
    covariance: NDArray[np.float64]
    range_m: float
    range_sigma_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """All faces of one image (possibly none), ``frame`` being the camera's name.

    The image is ``width`` x ``height`` px; ``X_BC`` is the camera's pose in ``base_link`` at ``stamp``.
    """

    stamp: float
    frame: str
    width: int
    height: int
    X_BC: Pose3
    faces: tuple[Face, ...]


@dataclass(frozen=True, slots=True)
class Darkness:
    """How bright one image is: ``luma`` in [0, 1], its mean; ``dark`` with hysteresis. ``frame`` names the camera."""

    percept_kind: ClassVar[PerceptKind] = PerceptKind("dark", "darkness before {subject}")

    stamp: float
    frame: str
    luma: float
    dark: bool

    @property
    def subjects(self) -> Mapping[str, float]:
        """The camera, if it is dark before it."""
        return {self.frame: 1.0} if self.dark else {}


@dataclass(frozen=True, slots=True)
class Confidence:
    """How well a perception works now: ``value`` in [0, 1], 1 as well as it can; ``reason`` in words where it is less
    ("the picture is dark")."""

    stamp: float
    value: float
    reason: str = ""


@dataclass(frozen=True, slots=True)
class LoudNoise:
    """A frame of sound much louder than those before it: ``ratio`` of its energy to their moving mean (thesis 4.2).

    ``level_db`` is the frame's level, dB of full scale. ``stamp`` is the time of the frame's first sample.
    """

    stamp: float
    ratio: float
    level_db: float


@dataclass(frozen=True, slots=True)
class SoundClass:
    """What kind of sound the second before ``stamp`` was, by features of the spectrum of one of the microphones.

    ``name`` is silence, voice-like, tonal, impulsive or broadband. From 200 Hz to 8 kHz, ``level_db`` is the level, dB
    of full scale, ``centroid_hz`` the mean frequency, and 85 % of the energy lie below ``rolloff_hz``. ``flatness`` in
    [0, 1]: 0 for a tone, 0.56 for white noise; ``onset_db`` is the steepest rise, dB. ``frame`` names the microphones.
    """

    percept_kind: ClassVar[PerceptKind] = PerceptKind("sound", "{subject} sound")

    stamp: float
    frame: str
    name: str
    level_db: float
    centroid_hz: float
    rolloff_hz: float
    flatness: float
    onset_db: float

    @property
    def subjects(self) -> Mapping[str, float]:
        """The class, unless it is silence."""
        return {} if self.name == "silence" else {self.name: 1.0}


@dataclass(frozen=True, slots=True)
class SoundSource:
    """A sound being tracked: ``direction`` (unit vector) from the microphones' middle, in ``base_link``'s axes.

    ``track`` keeps its number from birth to death. ``power`` in [0, 1] is how strongly the microphones agree on the
    direction; ``level_db`` how loud it is, dB of full scale. ``active`` whether it sounds now; ``speech`` in [0, 1] is
    the probability that it is a voice, NaN while unknown. ``range_m`` from the microphones' middle, with
    standard deviation ``range_sigma_m``, supposes a standing person's mouth (the height Gaussian).
    """

    track: int
    direction: tuple[float, float, float]
    power: float
    level_db: float
    active: bool
    speech: float
    range_m: float
    range_sigma_m: float


@dataclass(frozen=True, slots=True)
class SoundSources:
    """All sound sources tracked at ``stamp``, possibly none; ``p_BA`` (m): the microphones' middle, in B."""

    stamp: float
    p_BA: tuple[float, float, float]
    sources: tuple[SoundSource, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SeparatedSound:
    """Tracked sources each by itself: column i of ``samples`` (N, K) int16 is source ``tracks[i]``.

    Fields otherwise as in ``Audio``; ``rate`` may be lower than the microphones'.
    """

    stamp: float
    tracks: tuple[int, ...]
    samples: NDArray[np.int16]
    rate: int
    first_sample: int


@dataclass(frozen=True, slots=True)
class PlacedFace:
    """A face in one image of ``camera``, placed with the robot's pose at ``stamp``.

    ``azimuth`` (left positive) and ``elevation`` (rad) in the axes of B, from the camera as it was then; ``panorama``
    is both, from where the newest panorama was taken (None: there is none). ``range_m`` from the camera, with standard
    deviation ``range_sigma_m``. ``x``, ``y``, ``z`` (m) is its place in O and ``towards_O`` the heading (rad in O) in
    which it has the robot, all None before the pose at ``stamp`` is known. ``box`` is left, top, width, height (px) in
    the image of ``image`` (width, height) px.
    """

    track: int
    camera: str
    stamp: float
    azimuth: float
    elevation: float
    panorama: tuple[float, float] | None
    range_m: float | None
    range_sigma_m: float | None
    x: float | None
    y: float | None
    z: float | None
    towards_O: float | None
    score: float
    box: tuple[float, float, float, float]
    image: tuple[int, int]


@dataclass(frozen=True, slots=True)
class PlacedSound:
    """A tracked sound, placed with the robot's pose at ``stamp``: angles and place as in ``PlacedFace``.

    Angles and ``range_m`` are from the microphones' middle, which is at ``p_OA`` (m in O); ``v_O`` is the direction as
    a unit vector in the axes of O. Place and range are None where the distance is not known, all of O before the pose
    is. ``active``: it sounds now, else it did last at ``last_active``; ``speech`` is None while nothing has judged it.
    """

    track: int
    stamp: float
    azimuth: float
    elevation: float
    panorama: tuple[float, float] | None
    range_m: float | None
    range_sigma_m: float | None
    x: float | None
    y: float | None
    z: float | None
    p_OA: tuple[float, float, float] | None
    v_O: tuple[float, float, float] | None
    power: float
    level_db: float
    active: bool
    last_active: float
    speech: float | None


@dataclass(frozen=True, slots=True, eq=False)
class PlacedCode:
    """A QR code in one image of ``camera``: its ``corners`` (4, 2) float64 px, in the order of ``QRCode``, in the image
    of ``image`` (width, height) px."""

    text: str
    camera: str
    stamp: float
    corners: Annotated[NDArray[np.float64], Meta(extra_json_schema={"items": POINT})]
    image: tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class PlacedPercepts:
    """What the robot sees and hears at ``stamp``; published when it changes.

    ``faces`` by track and camera, ``sounds`` by track, ``noises`` of the last 2 s, ``codes`` by text and camera.
    """

    stamp: float
    faces: tuple[PlacedFace, ...] = ()
    sounds: tuple[PlacedSound, ...] = ()
    noises: tuple[LoudNoise, ...] = ()
    codes: tuple[PlacedCode, ...] = ()


PERCEPT_KINDS: Final = ("code", "face", "voice", "noise")
"""The kinds of percept events that are made of the messages here; other message types declare theirs."""


@dataclass(frozen=True, slots=True)
class PerceptEvent:
    """Something perceived appears, leaves or changes (docs/percept-events.md).

    ``name`` is ``kind``, a dot, and ``appears``, ``leaves`` or ``changes``; ``subject`` is which of its kind (a
    track's number, a code's text, a camera's frame; "" where there is but one). ``source`` names the sensor. ``stamp``
    is the capture time of what showed the event, ``since`` that of the first sighting. ``p_OP`` (m, in ``odom``) is
    where it was seen last and ``heading`` (rad, in ``odom``) in which direction from the robot; None where unknown.
    ``confidence`` in [0, 1] is that of the last sighting.
    """

    stamp: float
    name: str
    kind: str
    subject: str
    source: str
    since: float
    confidence: float
    p_OP: tuple[float, float, float] | None
    heading: float | None


@dataclass(frozen=True, slots=True)
class SalientRegion:
    """A direction that stands out: ``azimuth`` (left positive) and ``elevation`` (rad) from the head, in B's axes.

    ``saliency`` is the sum of the other members, what each feature gives to it, weighted with its gain.
    """

    azimuth: float
    elevation: float
    saliency: float
    motion: float
    color: float
    contrast: float
    faces: float
    sounds: float


@dataclass(frozen=True, slots=True)
class SalientRegions:
    """The most salient regions at ``stamp``, the most salient first, three at most; directions are from ``p_BH``, the
    middle of the sphere around the head (m in B)."""

    stamp: float
    p_BH: tuple[float, float, float]
    regions: tuple[SalientRegion, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SaliencyMap:
    """How salient all directions around the head are at ``stamp``.

    ``cells`` (rows, columns) uint8: 255 is the saliency ``full``, or more. Rows go from the top down, ``step`` rad
    each, with level in the middle; columns from azimuth +π to -π (left positive) in the axes of B.
    """

    stamp: float
    step: float
    full: float
    cells: Annotated[NDArray[np.uint8], Meta(extra_json_schema={"items": CELLS})]


@dataclass(frozen=True, slots=True)
class Fixation:
    """A direction that was looked at for long enough: ``azimuth`` (left positive) and ``elevation`` (rad) from the
    head, in the axes of B at ``stamp``."""

    stamp: float
    azimuth: float
    elevation: float

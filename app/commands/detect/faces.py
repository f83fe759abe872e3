"""``hbba detect faces FILE…``: faces in photographs and videos."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from app.commands.arguments import real
from app.commands.detect.outputs import exit_code
from app.commands.detect.pictures import (
    Found,
    add_pictures,
    counted,
    for_json,
    look_through,
)
from app.commands.output import aligned, print_json

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from app.modules.perception.faces.yunet import Detection, YuNetDetector

COMMAND = "hbba detect faces"
#: A face's landmarks in the order of the detector; right and left are the person's.
LANDMARKS = ("right_eye", "left_eye", "nose", "mouth_right", "mouth_left")


def add_parser(kinds: Any) -> None:
    parser = kinds.add_parser(
        "faces",
        help="faces in photographs and videos",
        description="Find faces in photographs and videos, by the robot's own detector (YuNet). Boxes are in pixels of "
        "the image held upright: left, top, width, height. In a video, a face keeps its number while it is in view. "
        "Exit code 0 if a face was found, 1 if none was, 2 if a file cannot be read (to its end) or does not exist.",
    )
    add_pictures(
        parser,
        "print one JSON document instead: also landmarks, files without faces, and a video's frames with their times",
        "write copies with the faces framed into FOLDER: JPEG of images, MP4 of videos",
    )
    parser.add_argument(
        "--threshold", type=real(0, 1), default=None, metavar="S", help="least score of a face, 0 to 1 (default 0.8)"
    )


def run(args: argparse.Namespace) -> int:
    from app.modules.perception.faces.yunet import THRESHOLD, YuNetDetector

    finder = YuNetDetector(THRESHOLD if args.threshold is None else args.threshold)
    documents = look_through(args, _Faces(finder), "look for faces", COMMAND)
    if args.json:
        print_json({"threshold": round(finder.threshold, 6), "files": for_json(documents)})
    else:
        _print_table(documents)
    return exit_code(documents, "found")


class _Faces:
    """Finds faces, and follows them through a video."""

    key = "faces"
    drawn = ".faces"

    def __init__(self, finder: YuNetDetector) -> None:
        self._finder = finder

    def seek(self, picture: NDArray[np.uint8]) -> list[Found]:
        return [_face(face) for face in self._finder.find_all_sizes(picture)]

    def begin(self) -> None:
        from app.modules.perception.faces.face_tracks import FaceTracks

        self._following = FaceTracks()
        self._tracks: dict[int, Found] = {}

    def follow(self, picture: NDArray[np.uint8], time_s: float) -> list[Found]:
        faces = self._finder.find_all_sizes(picture)
        numbers = self._following.see_in_image(time_s, "video", faces)
        found = []
        for number, face in zip(numbers, faces, strict=True):
            found.append({"track": number} | _face(face))
            track = self._tracks.setdefault(
                number, {"track": number, "begin_s": round(time_s, 3), "end_s": 0.0, "frames": 0, "score": 0.0}
            )
            track |= {"end_s": round(time_s, 3), "frames": track["frames"] + 1}
            if face.score > track["score"]:
                track |= {"score": round(face.score, 3), "best_s": round(time_s, 3)}
        return found

    def summary(self) -> tuple[str, list[Found]]:
        return "tracks", list(self._tracks.values())

    def draw(self, picture: NDArray[np.uint8], found: list[Found]) -> None:
        import cv2

        thick = max(2, round(max(picture.shape[:2]) / 400))
        for face in found:
            left, top, width, height = (round(side) for side in face["box"])
            cv2.rectangle(picture, (left, top), (left + width, top + height), (80, 220, 80), thick, cv2.LINE_AA)
            for u, v in face["landmarks"].values():
                cv2.circle(picture, (round(u), round(v)), thick, (255, 60, 60), cv2.FILLED, cv2.LINE_AA)
            words = f"{face['score']:.2f}" if "track" not in face else f"{face['track']}: {face['score']:.2f}"
            at = (left, max(12, top - 2 * thick))
            size = 0.25 * thick
            cv2.putText(picture, words, at, cv2.FONT_HERSHEY_SIMPLEX, size, (80, 220, 80), thick // 2 or 1)


def _face(face: Detection) -> Found:
    landmarks = {
        name: [round(u, 1), round(v, 1)] for name, (u, v) in zip(LANDMARKS, face.landmarks.tolist(), strict=True)
    }
    return {"score": round(face.score, 3), "box": [round(side, 1) for side in face.box], "landmarks": landmarks}


def _print_table(documents: list[Found]) -> None:
    read = [document for document in documents if "width" in document]
    photographs = [document for document in read if "duration_s" not in document]
    rows: list[tuple[str, ...]] = [("file", "score", "left", "top", "width", "height")]
    for document in photographs:
        rows += [
            (document["file"], f"{face['score']:.2f}", *(f"{side:.0f}" for side in face["box"]))
            for face in document["faces"]
        ]
        if not document["faces"]:
            rows.append((document["file"], "no face", "", "", "", ""))
    _print_rows(rows)
    rows = [("file", "face", "from s", "to s", "frames", "best score", "at s")]
    for document in read:
        for track in document.get("tracks", ()):
            seconds = (f"{track['begin_s']:.1f}", f"{track['end_s']:.1f}", str(track["frames"]))
            best = (f"{track['score']:.2f}", f"{track['best_s']:.1f}")
            rows.append((document["file"], str(track["track"]), *seconds, *best))
        if "duration_s" in document and not document["tracks"]:
            rows.append((document["file"], "no face", "", "", "", "", ""))
    _print_rows(rows)
    faces = sum(document["found"] for document in read)
    print(f"{faces} face{'s' * (faces != 1)} in {counted(read)}")


def _print_rows(rows: list[tuple[str, ...]]) -> None:
    """A table, where there is anything below its head."""
    if len(rows) < 2:
        return
    print(*aligned(rows, range(1, len(rows[0]))), sep="\n")

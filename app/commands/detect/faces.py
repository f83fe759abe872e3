"""``hbba detect faces FILE…``: the faces in anyone's photographs."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.commands.arguments import file_named
from app.commands.detect.images import FACES_DRAWN, each_image, find_images
from app.commands.detect.outputs import make_folder, unused
from app.commands.output import add_json, print_json
from app.errors import ConfigError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from app.modules.perception.faces.yunet import Detection

COMMAND = "hbba detect faces"
#: A face's landmarks in the order of the detector; right and left are the person's.
LANDMARKS = ("right_eye", "left_eye", "nose", "mouth_right", "mouth_left")


def add_parser(kinds: Any) -> None:
    """Declare ``hbba detect faces``."""
    parser = kinds.add_parser(
        "faces",
        help="faces in photographs",
        description="Find faces in photographs, by the robot's own detector (YuNet). Boxes are in pixels of the image "
        "held upright: left, top, width, height. Exit code 0 if a face was found, 1 if none was, 2 if a file cannot be "
        "read or does not exist.",
    )
    parser.add_argument(
        "files",
        nargs="+",
        type=file_named,
        metavar="FILE",
        help="an image, or a folder of images (no copies of --draw)",
    )
    add_json(parser, "print one JSON document instead: also landmarks, and files without faces")
    parser.add_argument(
        "--threshold", type=_share, default=None, metavar="S", help="least score of a face, 0 to 1 (default 0.8)"
    )
    parser.add_argument("--draw", type=Path, metavar="FOLDER", help="write copies with the faces framed into FOLDER")


def run(args: argparse.Namespace) -> int:
    """Look through the files. Raises ConfigError."""
    from app.modules.perception.faces.yunet import THRESHOLD, FaceFinder

    paths = find_images(args.files)
    finder = FaceFinder(THRESHOLD if args.threshold is None else args.threshold)
    drawing = None if args.draw is None else _Drawing(args.draw)
    documents = []
    for path, color, trouble in each_image(paths, "look for faces", COMMAND):
        faces = [] if color is None else finder.find_all_sizes(color)
        documents.append(_document(path, color, faces, trouble))
        if drawing is not None and color is not None:
            drawing.write(path, color, faces)
    if args.json:
        print_json({"threshold": round(finder.threshold, 6), "files": documents})
    else:
        _print_table(documents)
    if any("error" in document for document in documents):
        return 2
    return 0 if any(document["faces"] for document in documents) else 1


def _share(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"must be a number from 0 to 1, not {text!r}")
    return value


def _document(path: Path, color: NDArray[np.uint8] | None, faces: list[Detection], trouble: str) -> dict[str, Any]:
    if color is None:
        return {"file": str(path), "error": trouble, "faces": []}
    height, width = color.shape[:2]
    return {"file": str(path), "width": width, "height": height, "faces": [_face(face) for face in faces]}


def _face(face: Detection) -> dict[str, Any]:
    landmarks = {
        name: [round(u, 1), round(v, 1)] for name, (u, v) in zip(LANDMARKS, face.landmarks.tolist(), strict=True)
    }
    return {"score": round(face.score, 3), "box": [round(side, 1) for side in face.box], "landmarks": landmarks}


def _print_table(documents: list[dict[str, Any]]) -> None:
    rows = [("file", "score", "left", "top", "width", "height")]
    for document in documents:
        rows += [
            (document["file"], f"{face['score']:.2f}", *(f"{side:.0f}" for side in face["box"]))
            for face in document["faces"]
        ]
        if not document["faces"] and "error" not in document:
            rows.append((document["file"], "no face", "", "", "", ""))
    if len(rows) > 1:
        widths = [max(len(row[column]) for row in rows) for column in range(6)]
        for file, *cells in rows:
            figures = (cell.rjust(width) for cell, width in zip(cells, widths[1:], strict=True))
            print("  ".join((file.ljust(widths[0]), *figures)).rstrip())
    read = [document for document in documents if "error" not in document]
    faces = sum(len(document["faces"]) for document in read)
    print(f"{faces} face{'s' * (faces != 1)} in {len(read)} image{'s' * (len(read) != 1)}")


class _Drawing:
    """Copies of the photographs with the faces framed."""

    def __init__(self, folder: Path) -> None:
        make_folder(folder, "--draw")
        self._folder = folder
        self._names: set[str] = set()

    def write(self, path: Path, color: NDArray[np.uint8], faces: list[Detection]) -> None:
        """Write ``<name>.faces.jpg``; a number is added where two photographs have one name. Raises ConfigError."""
        import cv2

        picture = cv2.cvtColor(color, cv2.COLOR_RGB2BGR)
        thick = max(2, round(max(color.shape[:2]) / 400))
        for face in faces:
            left, top, width, height = (round(side) for side in face.box)
            cv2.rectangle(picture, (left, top), (left + width, top + height), (80, 220, 80), thick, cv2.LINE_AA)
            for u, v in face.landmarks.tolist():
                cv2.circle(picture, (round(u), round(v)), thick, (60, 60, 255), cv2.FILLED, cv2.LINE_AA)
            at = (left, max(12, top - 2 * thick))
            size = 0.25 * thick
            cv2.putText(
                picture, f"{face.score:.2f}", at, cv2.FONT_HERSHEY_SIMPLEX, size, (80, 220, 80), thick // 2 or 1
            )
        file = self._folder / f"{unused(path.stem, self._names)}{FACES_DRAWN}"
        _, jpeg = cv2.imencode(".jpg", picture, (cv2.IMWRITE_JPEG_QUALITY, 92))
        try:
            file.write_bytes(jpeg.tobytes())
        except OSError as failure:
            raise ConfigError(f"--draw: {file} cannot be written: {failure.strerror or failure}") from None

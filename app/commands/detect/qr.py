"""``hbba detect qr FILE…``: the QR codes in anyone's photographs."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.commands.arguments import file_named
from app.commands.detect.images import CODES_DRAWN, each_image, find_images
from app.commands.detect.outputs import make_folder, unused
from app.commands.output import add_json, print_json
from app.errors import ConfigError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    #: Text and corners (4, 2) px.
    Code = tuple[str, NDArray[np.float32]]

COMMAND = "hbba detect qr"


def add_parser(kinds: Any) -> None:
    """Declare ``hbba detect qr``."""
    parser = kinds.add_parser(
        "qr",
        help="QR codes in photographs",
        description="Read the QR codes in photographs, by the robot's own detector (zxing-cpp, with a second try on "
        "the image enlarged two times). Corners are in pixels of the image held upright, from the code's upper left, "
        "clockwise as printed. Exit code 0 if a code was read, 1 if none was, 2 if a file cannot be read or does not "
        "exist.",
    )
    parser.add_argument(
        "files",
        nargs="+",
        type=file_named,
        metavar="FILE",
        help="an image, or a folder of images (no copies of --draw)",
    )
    add_json(parser, "print one JSON document instead: also corners, and files without codes")
    parser.add_argument("--fisheye", action="store_true", help="images of a lens that fills them with a hemisphere")
    parser.add_argument("--draw", type=Path, metavar="FOLDER", help="write copies with the codes framed into FOLDER")


def run(args: argparse.Namespace) -> int:
    """Look through the files. Raises ConfigError."""
    paths = find_images(args.files)
    if args.draw is not None:
        make_folder(args.draw, "--draw")
    documents = []
    names: set[str] = set()
    for path, color, trouble in each_image(paths, "look for QR codes", COMMAND):
        codes = [] if color is None else _read(color, args.fisheye)
        documents.append(_document(path, color, codes, trouble))
        if args.draw is not None and color is not None:
            _draw(args.draw / f"{unused(path.stem, names)}{CODES_DRAWN}", color, codes)
    if args.json:
        print_json({"files": documents})
    else:
        _print_table(documents)
    if any("error" in document for document in documents):
        return 2
    return 0 if any(document["codes"] for document in documents) else 1


def _read(color: NDArray[np.uint8], fisheye: bool) -> list[Code]:
    import math

    import cv2
    import numpy as np

    from app.geometry import FisheyeModel, Pose3
    from app.messages import Image
    from app.modules.perception.fisheye_patches import FisheyePatches
    from app.modules.perception.qr_codes import decode, detect_panorama

    if not fisheye:
        return decode(np.asarray(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY), np.uint8))
    camera = FisheyeModel.from_fov(color.shape[1], color.shape[0], math.pi, math.pi)
    image = Image(0.0, "file", color, None, camera, Pose3.identity())
    # Nobody waits for the next image here: look everywhere.
    return [(code.text, code.corners) for code in detect_panorama(image, FisheyePatches(camera), most_patches=32)]


def _document(path: Path, color: NDArray[np.uint8] | None, codes: list[Code], trouble: str) -> dict[str, Any]:
    if color is None:
        return {"file": str(path), "error": trouble, "codes": []}
    found = [{"text": text, "corners": [[round(u, 1), round(v, 1)] for u, v in c.tolist()]} for text, c in codes]
    return {"file": str(path), "width": color.shape[1], "height": color.shape[0], "codes": found}


def _print_table(documents: list[dict[str, Any]]) -> None:
    rows = []
    for document in documents:
        rows += [(document["file"], json.dumps(code["text"], ensure_ascii=False)) for code in document["codes"]]
        if not document["codes"] and "error" not in document:
            rows.append((document["file"], "no code"))
    width = max((len(file) for file, _ in rows), default=0)
    for file, text in rows:
        print(f"{file.ljust(width)}  {text}")
    read = [document for document in documents if "error" not in document]
    codes = sum(len(document["codes"]) for document in read)
    print(f"{codes} code{'s' * (codes != 1)} in {len(read)} image{'s' * (len(read) != 1)}")


def _draw(file: Path, color: NDArray[np.uint8], codes: list[Code]) -> None:
    import cv2
    import numpy as np

    picture = cv2.cvtColor(color, cv2.COLOR_RGB2BGR)
    thick = max(2, round(max(color.shape[:2]) / 400))
    for _, corners in codes:
        outline = np.round(corners).astype(np.int32)
        cv2.polylines(picture, [outline], True, (80, 220, 80), thick, cv2.LINE_AA)
        # The first corner tells which way up the code is printed.
        cv2.circle(picture, (int(outline[0, 0]), int(outline[0, 1])), 2 * thick, (60, 60, 255), cv2.FILLED, cv2.LINE_AA)
    _, jpeg = cv2.imencode(".jpg", picture, (cv2.IMWRITE_JPEG_QUALITY, 92))
    try:
        file.write_bytes(jpeg.tobytes())
    except OSError as failure:
        raise ConfigError(f"--draw: {file} cannot be written: {failure.strerror or failure}") from None

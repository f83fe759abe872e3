"""``hbba detect qr FILE…``: QR codes in photographs and videos."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from app.commands.detect.outputs import exit_code
from app.commands.detect.pictures import Found, add_pictures, counted, for_json, look_through
from app.commands.output import print_json

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from app.modules.perception.fisheye_patches import FisheyePatches

    #: Text and corners (4, 2) px.
    Code = tuple[str, NDArray[np.float32]]

COMMAND = "hbba detect qr"


def add_parser(kinds: Any) -> None:
    parser = kinds.add_parser(
        "qr",
        help="QR codes in photographs and videos",
        description="Read the QR codes in photographs and videos, by the robot's own detector (zxing-cpp, with a "
        "second try on the image enlarged two times). Corners are in pixels of the image held upright, from the code's "
        "upper left, clockwise as printed. Exit code 0 if a code was read, 1 if none was, 2 if a file cannot be read "
        "(to its end) or does not exist.",
    )
    add_pictures(
        parser,
        "print one JSON document instead: also corners, files without codes, and a video's frames with their times",
        "write copies with the codes framed into FOLDER: JPEG of images, MP4 of videos",
    )
    parser.add_argument("--fisheye", action="store_true", help="images of a lens that fills them with a hemisphere")


def run(args: argparse.Namespace) -> int:
    documents = look_through(args, _Codes(args.fisheye), "look for QR codes", COMMAND)
    if args.json:
        print_json({"files": for_json(documents)})
    else:
        _print_table(documents)
    return exit_code(documents, "found")


class _Codes:
    """Reads codes; in a video, those of one text are one."""

    key = "codes"
    drawn = ".codes"

    def __init__(self, fisheye: bool) -> None:
        self._fisheye = fisheye
        self._patches: tuple[tuple[int, ...], FisheyePatches] | None = None

    def seek(self, picture: NDArray[np.uint8]) -> list[Found]:
        read = self._read_fisheye(picture) if self._fisheye else _read(picture)
        return [{"text": text, "corners": [[round(u, 1), round(v, 1)] for u, v in c.tolist()]} for text, c in read]

    def begin(self) -> None:
        self._texts: dict[str, Found] = {}

    def follow(self, picture: NDArray[np.uint8], time_s: float) -> list[Found]:
        found = self.seek(picture)
        for text in dict.fromkeys(code["text"] for code in found):
            row = self._texts.setdefault(text, {"text": text, "begin_s": round(time_s, 3), "end_s": 0.0, "frames": 0})
            row |= {"end_s": round(time_s, 3), "frames": row["frames"] + 1}
        return found

    def summary(self) -> tuple[str, list[Found]]:
        return "codes", list(self._texts.values())

    def draw(self, picture: NDArray[np.uint8], found: list[Found]) -> None:
        import cv2
        import numpy as np

        thick = max(2, round(max(picture.shape[:2]) / 400))
        for code in found:
            outline = np.round(np.array(code["corners"])).astype(np.int32)
            cv2.polylines(picture, [outline], True, (80, 220, 80), thick, cv2.LINE_AA)
            # The first corner says which way up the code is printed.
            first = (int(outline[0, 0]), int(outline[0, 1]))
            cv2.circle(picture, first, 2 * thick, (255, 60, 60), cv2.FILLED, cv2.LINE_AA)

    def _read_fisheye(self, picture: NDArray[np.uint8]) -> list[Code]:
        import math

        from app.base.geometry import FisheyeModel, Pose3
        from app.messages import Image
        from app.modules.perception.fisheye_patches import FisheyePatches
        from app.modules.perception.qr_codes import detect_panorama

        size = picture.shape[:2]
        camera = FisheyeModel.from_fov(size[1], size[0], math.pi, math.pi)
        if self._patches is None or self._patches[0] != size:
            self._patches = size, FisheyePatches(camera)
        image = Image(0.0, "file", color=picture, depth=None, camera=camera, X_BC=Pose3.identity())
        # No next image waits here: search the whole picture.
        return [(code.text, code.corners) for code in detect_panorama(image, self._patches[1], most_patches=32)]


def _read(picture: NDArray[np.uint8]) -> list[Code]:
    import cv2
    import numpy as np

    from app.modules.perception.qr_codes import decode

    return decode(np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8))


def _print_table(documents: list[Found]) -> None:
    rows = []
    read = [document for document in documents if "width" in document]
    for document in read:
        for code in document["codes"]:
            cells = [document["file"], json.dumps(code["text"], ensure_ascii=False)]
            if "frames" in code:
                frames = f"{code['frames']} frame{'s' * (code['frames'] != 1)}"
                cells[1] += f"  {code['begin_s']:.1f} to {code['end_s']:.1f} s, {frames}"
            rows.append(cells)
        if not document["codes"]:
            rows.append([document["file"], "no code"])
    width = max((len(file) for file, _ in rows), default=0)
    for file, text in rows:
        print(f"{file.ljust(width)}  {text}")
    codes = sum(document["found"] for document in read)
    print(f"{codes} code{'s' * (codes != 1)} in {counted(read)}")

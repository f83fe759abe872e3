"""The program for a laptop, on files in place of its camera and microphone: it reads, sees and hears what is there."""

from __future__ import annotations

import argparse
import asyncio
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import segno
import soundfile

from app.base import paths
from app.base.errors import ConfigError
from app.commands.body_options import chosen
from app.messages import Faces, LoudNoise, PerceptEvent, QRCodes
from app.program.system import System
from app.robots.devices.config import DevicesConfig
from app.robots.factory import create_link
from app.runtime.clock import RealClock
from tests.patience import PATIENCE_S

WEBCAM = paths.config_dir() / "robots" / "webcam.yaml"
PORTRAIT = Path(__file__).parents[3] / "app" / "robots" / "simulated" / "scenery" / "faces" / "pilot.jpg"
RATE = 48000


def arguments(**given: Any) -> argparse.Namespace:
    nothing = dict.fromkeys(("config", "camera", "microphones", "scenario"))
    return argparse.Namespace(**({"robot": WEBCAM} | nothing | given))


def desk(folder: Path) -> Path:
    """A picture of a person beside a QR code."""
    picture = np.full((480, 640, 3), 170, np.uint8)
    portrait = cv2.resize(np.asarray(cv2.imread(str(PORTRAIT))), (240, 320), interpolation=cv2.INTER_AREA)
    picture[80:400, 40:280] = portrait
    segno.make_qr("hello").save(str(folder / "code.png"), scale=8)
    code = np.asarray(cv2.imread(str(folder / "code.png")))
    picture[100 : 100 + code.shape[0], 350 : 350 + code.shape[1]] = code
    cv2.imwrite(str(folder / "desk.png"), picture)
    return folder / "desk.png"


def clap(folder: Path) -> Path:
    """Two and a half quiet seconds and a clap."""
    rng = np.random.default_rng(3)
    sound = 0.002 * rng.standard_normal(3 * RATE)
    sound[120_000:122_400] += 0.5 * rng.standard_normal(2400) * np.exp(-np.arange(2400) / 400)
    soundfile.write(str(folder / "clap.wav"), sound, RATE, subtype="PCM_16")
    return folder / "clap.wav"


@pytest.mark.slow
@pytest.mark.blocking(reason="reads its configuration on the loop, as hbba run does before anybody drives")
async def test_a_code_a_face_and_a_clap_are_noticed(tmp_path: Path) -> None:
    configuration, body = chosen(arguments(camera=str(desk(tmp_path)), microphones=str(clap(tmp_path))))
    clock = RealClock()
    system = System(configuration, link=create_link(body, clock.offset), clock=clock)
    noticed: dict[type | str, asyncio.Event] = {kind: asyncio.Event() for kind in (QRCodes, Faces, LoudNoise)}
    noticed |= {name: asyncio.Event() for name in ("code.appears", "face.appears", "noise.appears")}

    def look(message: Any) -> None:
        found = getattr(message, "codes", None) or getattr(message, "faces", None)
        if isinstance(message, LoudNoise) or found:
            noticed[type(message)].set()

    for name in ("qr_codes", "faces", "loud_noises"):
        system.graph.channels[name].observe(look)

    def happen(event: PerceptEvent) -> None:
        if event.name in noticed:
            noticed[event.name].set()

    system.graph.channels["percept_events"].observe(happen)
    async with asyncio.timeout(PATIENCE_S), system:
        await asyncio.gather(*(event.wait() for event in noticed.values()))
        assert not [state.problem for state in system.supervisor.states.values() if state.problem]
        assert system.translator.current is not None
        assert {s.cls for s in system.translator.current.strategies} >= {"FindQRCodes", "LocateFaces", "DetectNoises"}
        named = {event.subject for event in system.timeline.query(kinds=["percept"])}
        assert named >= {"code.appears", "face.appears", "noise.appears"}
        # Nothing is desired in vain, not even after the clap.
        assert {desire.cls for desire in system.workspace.desires()} <= set(system.table.classes)


def test_the_body_names_its_program_and_options_its_devices() -> None:
    configuration, body = chosen(arguments(camera="/dev/video7", microphones="USB"))
    assert isinstance(body, DevicesConfig)
    assert "Camera" in configuration.program.modules
    assert body.camera is not None
    assert body.camera.source == "/dev/video7"
    assert body.microphones is not None
    assert body.microphones.source == "USB"


def test_devices_are_refused_where_there_are_none(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"--camera.*body of devices, and IRL-1/TR is none"):
        chosen(arguments(robot=None, camera="0"))
    mute = tmp_path / "mute.yaml"
    mute.write_text(f"kind: devices\nmodel: {WEBCAM.parent / 'desk.urdf'}\ncamera: {{}}\n")
    with pytest.raises(ConfigError, match=r"--microphones.*has no microphones to be replaced"):
        chosen(arguments(robot=mute, config=paths.config_dir() / "webcam.yaml", microphones="a.wav"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("kind: devices\nmodel: gone.urdf\n", "body.yaml:2: model: there is no file"),
        ("kind: devices\nmodel: desk.urdf\ncamera: {fov: 3}\n", "body.yaml:3: camera.fov"),
        (
            "kind: devices\nmodel: desk.urdf\nmicrophones: {link: nose}\n",
            "has no link 'nose' for a device of This computer",
        ),
        (
            "kind: devices\nmodel: desk.urdf\nactuators:\n  neck: {joints: [neck_joint]}\n",
            "body.yaml:3: actuators: a body of devices has no motors",
        ),
    ],
)
def test_mistakes_are_named_by_file_and_line(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "desk.urdf").write_text((WEBCAM.parent / "desk.urdf").read_text())
    body = tmp_path / "body.yaml"
    body.write_text(text)
    with pytest.raises(ConfigError) as refused:
        create_link(chosen(arguments(robot=body, config=paths.config_dir() / "webcam.yaml"))[1], 0.0)
    assert said in str(refused.value)

"""The page of ``hbba body show``: a model with a slider for each joint."""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rich
import viser
from viser import _messages as messages

from app.base.kinematic_model import Joint, load_model
from app.console.view.body_nodes import Body, BodyNodes
from app.robots.importing.groups import proposed_groups

#: Ends of the slider of a joint without limits: rad, m.
_TURN, _WAY_M = math.pi, 1.0
_BLUE = (30, 90, 220)


def serve_model(path: Path, footprint: tuple[tuple[float, float], ...], port: int) -> int:
    """Serve the model of the URDF file ``path`` on ``port`` of this computer until a signal comes.

    Raises ConfigError, ValueError or OSError for a model that cannot be read.
    """
    model, body = load_model(path), Body(path)
    rich.get_console().quiet = True  # viser's banner, with an address that is not for users
    server = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
    for kind in (messages.ShareUrlRequest, messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(kind)
    try:
        server.scene.set_up_direction("+z")
        server.initial_camera.position = (1.8, -1.8, 1.5)
        server.initial_camera.look_at = (0.0, 0.0, 0.5)
        server.scene.add_grid("/floor", width=4.0, height=4.0, cell_size=0.25)
        nodes = body.add_to(server.scene, "/body")
        if footprint:
            corners = np.array([(*corner, 0.005) for corner in (*footprint, footprint[0])])
            segments = np.stack((corners[:-1], corners[1:]), axis=1)
            server.scene.add_line_segments(
                "/footprint", segments, colors=_BLUE, thickness=3.0, thickness_units="screen"
            )
        joints = {name: model.joints[name] for name in model.joint_names}
        sliders = _add_sliders(server, joints, proposed_groups(model), nodes)
        _add_reset(server, sliders)
        print(f"{path}: http://127.0.0.1:{server.get_port()}  (Ctrl-C ends it)", flush=True)
        _wait_for_signal()
    finally:
        server.stop()
    return 0


def _add_sliders(
    server: viser.ViserServer, joints: dict[str, Joint], groups: dict[str, tuple[str, ...]], nodes: BodyNodes
) -> list[Any]:
    others = tuple(name for name in joints if not any(name in group for group in groups.values()))
    sliders: list[Any] = []
    for group, names in {**groups, **({"wheels and others": others} if others else {})}.items():
        with server.gui.add_folder(group):
            for name in names:
                lower, upper = slider_ends(joints[name])
                start = min(max(0.0, lower), upper)
                slider = server.gui.add_slider(name, lower, upper, step=(upper - lower) / 400, initial_value=start)
                nodes.move({name: start})
                slider.on_update(_mover(name, nodes))
                sliders.append(slider)
    return sliders


def slider_ends(joint: Joint) -> tuple[float, float]:
    """Least and greatest position (rad, m) of a joint's slider."""
    reach = _WAY_M if joint.kind == "prismatic" else _TURN
    if joint.kind == "continuous" or not math.isfinite(joint.upper - joint.lower) or joint.lower >= joint.upper:
        return -reach, reach
    return joint.lower, joint.upper


def _mover(name: str, nodes: BodyNodes) -> Callable[[Any], None]:
    def move(event: Any) -> None:
        nodes.move({name: float(event.target.value)})

    return move


def _add_reset(server: viser.ViserServer, sliders: list[Any]) -> None:
    button = server.gui.add_button("All joints to 0")

    @button.on_click
    def _(_: Any) -> None:
        for slider in sliders:
            slider.value = min(max(0.0, slider.min), slider.max)


def _wait_for_signal() -> None:
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    ended.wait()

"""Output files of ``hbba slam --out``: the map in ROS's format and as a picture, its pose graph, the trajectory."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from app.base.errors import ConfigError

if TYPE_CHECKING:
    from app.messages import OccupancyGrid
    from app.modules.perception.slam.offline_mapping import MappedLog
    from app.modules.perception.slam.self_check import CheckResult


def write(folder: Path, log: MappedLog, check: CheckResult) -> list[str]:
    """Write all files into ``folder``, which is there; returns their names. Raises ConfigError."""
    from app.maps.map_file import pgm_bytes, yaml_text
    from app.maps.picture import shown_png
    from app.modules.perception.slam.storage import write_state

    grid = drawn(log)
    files = {
        "map.yaml": yaml_text(grid, "map.pgm").encode(),
        "map.pgm": pgm_bytes(grid),
        "map.png": shown_png(grid),
        "trajectory.tum": _tum(log).encode(),
        "trajectory.csv": _csv(log, check).encode(),
    }
    try:
        for name, content in files.items():
            (folder / name).write_bytes(content)
        write_state(folder / "graph.npz", log.slam.state())
    except OSError as failure:
        raise ConfigError(f"--out: {folder} cannot be written to: {failure.strerror or failure}") from None
    return [str(folder / name) for name in (*files, "graph.npz")]


def drawn(log: MappedLog) -> OccupancyGrid:
    """The occupancy grid of all keyframes, cropped to the known cells."""
    from app.messages import OccupancyGrid, read_only
    from app.modules.perception.slam.map_rendering import MapRenderer
    from app.modules.perception.slam.occupancy import cropped

    drawing = MapRenderer()
    keyframes = log.slam.keyframes
    poses = {id: log.slam.pose(id) for id in keyframes}
    while drawing.update(keyframes, poses):
        pass
    counts = drawing.counts
    counts.refresh()
    rows, columns = cropped(counts.cells)
    origin = (
        counts.origin[0] + columns.start * counts.resolution_m,
        counts.origin[1] + rows.start * counts.resolution_m,
    )
    cells = read_only(np.ascontiguousarray(counts.cells[rows, columns]))
    return OccupancyGrid(
        float(log.stamps()[-1]),
        "map",
        cells=cells,
        resolution_m=counts.resolution_m,
        origin=origin,
        version=log.slam.version,
    )


def _tum(log: MappedLog) -> str:
    """``stamp x y z qx qy qz qw`` of each scan."""
    lines = ["# stamp x y z qx qy qz qw"]
    for stamp, (x, y, theta) in zip(log.stamps(), log.poses(), strict=True):
        lines.append(f"{stamp:.6f} {x:.5f} {y:.5f} 0 0 0 {math.sin(theta / 2):.7f} {math.cos(theta / 2):.7f}")
    return "\n".join(lines) + "\n"


def _csv(log: MappedLog, check: CheckResult) -> str:
    """``sigma_…`` on the map around at the time, ``map_sigma_m`` on the whole map, seen from its first keyframe."""
    lines = ["scan,stamp,x_m,y_m,theta_rad,sigma_x_m,sigma_y_m,sigma_theta_rad,inliers,map_sigma_m"]
    for row, (x, y, theta) in zip(log.rows, log.poses(), strict=True):
        sigmas = ",".join(f"{sigma:.5f}" for sigma in row.sigmas)
        whole = check.sigmas_m[log.kept(row.keyframe)[0]]
        lines.append(f"{row.number},{row.stamp:.6f},{x:.5f},{y:.5f},{theta:.6f},{sigmas},{row.inliers:.3f},{whole:.4f}")
    return "\n".join(lines) + "\n"

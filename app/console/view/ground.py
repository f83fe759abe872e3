"""The nodes of what lies on the floor: the map with its zones, the costmap, the path and the goal.

What is on the map hangs below one node with the map's pose in odometry's frame, so that all of it moves at once when
that jumps; the costmap and all that is seen stay where they are. Names are fixed and nothing is removed. Of all this
only the map's picture is transparent: viser sorts what is by its middle, and of two the one behind may not be drawn.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import trimesh
import viser
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.base.model_shapes import merged
from app.console.view.drawing import moved, pose_arrays, thinned
from app.console.view.floor import KEEP_OUT, SLOW, Layer, cost_points, floor_layer, rails, ribbon
from app.console.view.map_pose import MapPose
from app.console.view.mark_nodes import arrow_mesh
from app.console.view.scene_state import World
from app.console.view.viewer_rate import Pace
from app.console.view.viewpoints import MapExtent
from app.console.view.walls import box_ends, wall_boxes
from app.messages import OccupancyGrid, PlannedPath, Zones

#: Least time (s) between two pictures of the map, and of the costmap; longer where drawing takes long.
MAP_PERIOD_S = 2.0
COSTMAP_PERIOD_S = 0.4
_PERIODS = 10.0

_WAY_COLOR = (90, 230, 160)
_WALL_COLOR = (132, 148, 172)
#: Over the floor (m), so that none flickers through another.
_FLOOR_Z, _COSTMAP_Z, _PATH_Z = 0.01, 0.03, 0.04
#: Turns a picture, whose rows viser draws downwards and away from who looks from above.
_FACE_UP = (0.0, 1.0, 0.0, 0.0)


def layer_period_s(shortest_s: float, period_s: float) -> float:
    """The time to leave between two pictures of a layer, at a view that is updated every ``period_s``."""
    return max(shortest_s, _PERIODS * period_s)


#: The messages that a picture of the floor is made of.
Floor = tuple[OccupancyGrid | None, Zones | None]


class FloorLayers:
    """Pictures of the floor, made once for all viewers. For one thread."""

    def __init__(self) -> None:
        self._floor: Floor = (None, None)
        self._layer: Layer | None = None

    def of(self, floor: Floor) -> Layer | None:
        """The picture of ``floor``; None where there is nothing on it."""
        if not _same(floor, self._floor):
            grid, zones = self._floor = floor
            self._layer = floor_layer(grid, () if zones is None else zones.zones)
        return self._layer


def _same(one: Floor, other: Floor) -> bool:
    return one[0] is other[0] and one[1] is other[1]


class Ground:
    """The floor of one viewer, below the node ``world`` of its ``client``."""

    def __init__(self, client: viser.ClientHandle, world: str, layers: FloorLayers) -> None:
        self._scene = scene = client.scene
        self._world = world
        self._layers = layers
        self._frame = scene.add_frame(f"{world}/map", show_axes=False, visible=False)
        self._pose: Pose2 | None = None
        self._map_pose = MapPose()
        self._picture: viser.ImageHandle | None = None
        self._floor: Floor = (None, None)
        self._floor_due = 0.0
        self._layer: Layer | None = None
        self._walls = np.zeros((0, 3), np.float32)
        self._points: viser.PointCloudHandle | None = None
        self._costmap: OccupancyGrid | None = None
        self._costmap_due = 0.0
        self._meshes: dict[str, viser.MeshHandle] = {}
        self._path: tuple[PlannedPath | None, Pose2 | None] = (None, None)
        self._goal: tuple[float, float, float | None] | None = None

    @property
    def extent(self) -> MapExtent | None:
        """The known part of the map, once it is shown and known where it lies."""
        layer = self._layer
        if layer is None or self._pose is None or self._floor[0] is None:
            return None
        return MapExtent(self._pose @ Pose2(*layer.center), layer.size)

    @property
    def pose(self) -> Pose2 | None:
        """``X_OM``, where the map lies; None while that is not known."""
        return self._pose

    @property
    def walls(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and greatest corners (N, 3), m on the map, of the walls that are shown."""
        return box_ends(self._walls if self._pose is not None else self._walls[:0])

    def draw(self, world: World, now: float, pace: Pace) -> int:
        """Bring it up to ``world`` as ``pace`` allows. Returns how many parts were new."""
        new = self._draw_floor((world.map, world.zones), now, layer_period_s(MAP_PERIOD_S, pace.period_s))
        X_OM = self._where(world)
        new += self._place(X_OM)
        new += self._draw_costmap(world.costmap if pace.costmap else None, now, pace)
        new += self._draw_path(world.path, self._pose)
        return new + self._draw_goal(world.goal)

    def _draw_floor(self, floor: Floor, now: float, period_s: float) -> int:
        gone = floor[0] is None and self._floor[0] is not None
        if _same(floor, self._floor) or (now < self._floor_due and not gone):
            return 0
        self._floor_due = now + period_s
        if floor[1] is not self._floor[1]:
            for kind, color in (("keep_out", KEEP_OUT), ("slow", SLOW)):
                self._mesh(f"map/{kind}", *rails(() if floor[1] is None else floor[1].zones, kind), color)
        if floor[0] is not self._floor[0]:
            self._walls, faces = wall_boxes(floor[0])
            self._mesh("map/walls", self._walls, faces, _WALL_COLOR)
        self._floor = floor
        self._layer = layer = self._layers.of(floor)
        if layer is None:
            if self._picture is not None:
                self._picture.visible = False
            return 1
        position = (*layer.center, _FLOOR_Z)
        if self._picture is None:
            self._picture = self._scene.add_image(
                f"{self._world}/map/floor",
                layer.rgba,
                *layer.size,
                format="png",
                wxyz=_FACE_UP,
                position=position,
                cast_shadow=False,
                receive_shadow=False,
            )
        else:
            self._picture.image = layer.rgba
            self._picture.render_width, self._picture.render_height = layer.size
            self._picture.position = np.array(position)
            self._picture.visible = True
        return 1

    def _draw_costmap(self, costmap: OccupancyGrid | None, now: float, pace: Pace) -> int:
        if costmap is self._costmap or (costmap is not None and now < self._costmap_due):
            return 0
        self._costmap = costmap
        if costmap is None:
            if self._points is not None:
                self._points.visible = False
            return 1
        self._costmap_due = now + layer_period_s(COSTMAP_PERIOD_S, pace.period_s)
        points, colors = cost_points(costmap)
        chosen = thinned(len(points), pace.points)
        if self._points is None:
            self._points = self._scene.add_point_cloud(
                f"{self._world}/costmap",
                points[chosen],
                colors[chosen],
                point_size=costmap.resolution_m,
                point_shape="square",
                point_shading="flat",
                precision="float16",
                position=(0.0, 0.0, _COSTMAP_Z),
            )
        else:
            self._points.points, self._points.colors = points[chosen].astype(np.float16), colors[chosen]
            self._points.visible = len(chosen) > 0
        return 1

    def _where(self, world: World) -> Pose2 | None:
        """X_OM for the map whose picture is shown."""
        if world.localization is None:
            self._map_pose = MapPose()
            return None
        self._map_pose.take(world.localization)
        shown = self._floor[0]
        return self._map_pose.at(math.inf if shown is None else shown.stamp)

    def _place(self, X_OM: Pose2 | None) -> int:
        before = self._pose
        if X_OM is None or (before is not None and not moved(before, X_OM)):
            if X_OM is None and before is not None:
                self._frame.visible = False
                self._pose = None
            return 0
        self._pose = X_OM
        wxyz, position = pose_arrays(X_OM)
        self._frame.wxyz, self._frame.position = np.array(wxyz), np.array(position)
        if before is None:
            self._frame.visible = True
        return 1

    def _draw_path(self, path: PlannedPath | None, X_OM: Pose2 | None) -> int:
        # One in odom stays where it is when the map moves: it is given in the map's frame as that lies now.
        X_MP = X_OM.inverse() if X_OM is not None and path is not None and path.frame == "odom" else None
        if path is self._path[0] and self._path[1] == X_MP:
            return 0
        self._path = (path, X_MP)
        vertices, faces = ribbon(np.zeros((0, 2)) if path is None else path.poses[:, :2])
        if X_MP is not None:
            vertices = X_MP.to_pose3().transform(vertices).astype(np.float32)
        vertices[:, 2] = _PATH_Z
        self._mesh("map/path", vertices, faces, _WAY_COLOR)
        return 1

    def _draw_goal(self, goal: tuple[float, float, float | None] | None) -> int:
        if goal == self._goal:
            return 0
        self._goal = goal
        if goal is None:
            for name in ("map/goal", "map/heading"):
                if name in self._meshes:
                    self._meshes[name].visible = False
            return 1
        x, y, heading = goal
        wxyz, position = pose_arrays(Pose2(x, y, heading or 0.0))
        for name, mesh in (("map/goal", flag_mesh), ("map/heading", heading_mesh)):
            if name not in self._meshes:
                shape = mesh()
                self._mesh(name, shape.vertices, shape.faces, _WAY_COLOR)
            node = self._meshes[name]
            node.wxyz, node.position = np.array(wxyz), np.array(position)
            node.visible = name == "map/goal" or heading is not None
        return 1

    def _mesh(self, name: str, vertices: NDArray[Any], faces: NDArray[Any], color: tuple[int, int, int]) -> None:
        """Make the mesh ``name``, or give it another shape; one without faces is hidden."""
        node = self._meshes.get(name)
        if len(faces) == 0:
            if node is not None:
                node.visible = False
        elif node is None:
            self._meshes[name] = self._scene.add_mesh_simple(
                f"{self._world}/{name}",
                vertices,
                faces,
                color=color,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )
        else:
            node.vertices, node.faces = vertices, faces
            node.visible = True


def flag_mesh() -> trimesh.Trimesh:
    """A flag on a pole at the origin."""
    pole = trimesh.creation.cylinder(radius=0.018, segment=[(0, 0, 0), (0, 0, 0.9)], sections=8)
    foot = trimesh.creation.cylinder(radius=0.12, height=0.02, sections=24)
    corners = np.array([(0, 0, 0.9), (0, 0, 0.62), (0, 0.34, 0.76)], np.float64)
    flag = trimesh.Trimesh(corners, [(0, 1, 2)], process=False)
    return merged([pole, foot, flag])


def heading_mesh() -> trimesh.Trimesh:
    """An arrow on the floor along x."""
    arrow = arrow_mesh()
    arrow.apply_transform(np.diag([0.7, 0.7, 0.25, 1.0]))
    arrow.apply_translation((0, 0, 0.04))
    return arrow

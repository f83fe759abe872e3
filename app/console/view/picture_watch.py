"""The camera's picture for viewers that look through the camera: followed only while there are such, and placed."""

from __future__ import annotations

from app.base.geometry import CameraModel
from app.base.pose_buffer import PoseBuffer
from app.console import reports
from app.console.taps import Tap
from app.console.view.scene_state import Picture
from app.messages import EncodedImage, Image
from app.runtime.graph import Graph

CHANNEL = "camera_jpeg"
#: So many pictures wait for odometry to reach them.
_WAITING = 4


class PictureWatch:
    """Follows the pictures that people see, and where each was taken."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._tap: Tap[EncodedImage] | None = None
        self._waiting: list[EncodedImage] = []
        self._placed: Picture | None = None

    @property
    def eye(self) -> str:
        """The frame that the pictures are in; "" without any."""
        for slot in self._graph.modules.values():
            if CHANNEL in slot.spec.outputs.values():
                return self._graph.specs[CHANNEL].frame
        return ""

    def watch(self, wanted: bool) -> None:
        """Begin or end to follow them."""
        if wanted and self._tap is None and CHANNEL in self._graph.channels:
            channel = self._graph.channel(CHANNEL)
            self._tap = Tap(channel, f"console.view.{CHANNEL}", self._take)
            if isinstance(channel.latest, EncodedImage):
                self._take(channel.latest)
        elif not wanted:
            self.close()

    def close(self) -> None:
        if self._tap is not None:
            self._tap.close()
            self._tap = None
            self.forget()

    def forget(self) -> None:
        """Nothing is where it was."""
        self._waiting.clear()
        self._placed = None

    def placed(self, poses: PoseBuffer) -> Picture | None:
        """The newest picture whose instant ``poses`` (of the base in odometry) know; None before one."""
        for image in reversed(self._waiting):
            X_OB, camera = poses.at(image.stamp), self._camera()
            if X_OB is not None and camera is not None:
                self._placed = Picture(image, camera, X_OB.to_pose3() @ image.X_BC)
                self._waiting = [later for later in self._waiting if later.stamp > image.stamp]
                break
        return self._placed

    def _take(self, image: EncodedImage) -> None:
        self._waiting = [*self._waiting, image][-_WAITING:]

    def _camera(self) -> CameraModel | None:
        """The camera of the images that the pictures are made of."""
        for slot in self._graph.modules.values():
            if CHANNEL in slot.spec.outputs.values():
                for name in slot.spec.inputs.values():
                    taken = reports.latest(self._graph, name)
                    if isinstance(taken, Image) and isinstance(taken.camera, CameraModel):
                        return taken.camera
        return None

"""Frame buffers that fit their pictures: what is drawn and measured in them is the same as in MuJoCo's own."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from app.robots.simulated.frame_buffers import FrameBuffers
from app.robots.simulated.gl import gl_environment
from tests.robots.conftest import needs_gl

SIZE = (96, 64)
_FRAMEBUFFER, _STENCIL_ATTACHMENT, _OBJECT_TYPE = 0x8D40, 0x8D20, 0x8CD0
SCENE = """
<mujoco>
  <visual><quality offsamples="{samples}"/></visual>
  <worldbody>
    <light pos="0 0 3"/>
    <geom type="plane" size="5 5 1" rgba="0.2 0.5 0.3 1"/>
    <geom type="sphere" size="0.3" pos="0 0 0.4" rgba="0.9 0.2 0.1 1"/>
    <geom type="box" size="0.2 0.3 0.4" pos="0.3 0.4 0.3" rgba="0.1 0.2 0.9 1"/>
  </worldbody>
</mujoco>
"""

pytestmark = [
    needs_gl,
    pytest.mark.skipif(gl_environment().get("MUJOCO_GL") != "egl", reason="OpenGL is not found through EGL"),
]


class Scene:
    def __init__(self, samples: int = 0) -> None:
        self.model = mujoco.MjModel.from_xml_string(SCENE.format(samples=samples))
        self.gl = mujoco.GLContext(16, 16)
        self.gl.make_current()
        self.context = mujoco.MjrContext(self.model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self.context)
        mujoco.mjr_resizeOffscreen(*SIZE, self.context)

    def picture(self, width: int = SIZE[0], height: int = SIZE[1]) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        data, scene = mujoco.MjData(self.model), mujoco.MjvScene(self.model, maxgeom=10)
        mujoco.mj_forward(self.model, data)
        camera = mujoco.MjvCamera()
        mujoco.mjv_defaultFreeCamera(self.model, camera)
        every = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self.model, data, mujoco.MjvOption(), None, camera, every, scene)
        rectangle = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(rectangle, scene, self.context)
        color, depth = np.zeros((height, width, 3), np.uint8), np.zeros((height, width), np.float32)
        mujoco.mjr_readPixels(color, depth, rectangle, self.context)
        return color, depth

    def has_stencil(self) -> bool:
        """Whether there is a stencil in the frame buffer that is drawn in."""
        library = ctypes.CDLL("libEGL.so.1")
        library.eglGetProcAddress.restype = ctypes.c_void_p
        arguments = (ctypes.c_uint, ctypes.c_uint, ctypes.c_uint, ctypes.POINTER(ctypes.c_int))
        address = library.eglGetProcAddress(b"glGetFramebufferAttachmentParameteriv")
        found = ctypes.c_int(-1)
        ctypes.CFUNCTYPE(None, *arguments)(address)(
            _FRAMEBUFFER, _STENCIL_ATTACHMENT, _OBJECT_TYPE, ctypes.byref(found)
        )
        return found.value != 0

    def close(self) -> None:
        self.context.free()
        self.gl.free()


@pytest.fixture
def scene() -> Iterator[Scene]:
    scene = Scene()
    yield scene
    scene.close()


def test_pictures_and_depths_are_those_of_mujocos_own_frame_buffer(scene: Scene) -> None:
    color, depth = scene.picture()
    assert color.std() > 10
    assert np.unique(depth).size > 100
    assert scene.has_stencil()
    buffers = FrameBuffers(scene.context)
    buffers.use(*SIZE)
    assert not scene.has_stencil()
    again = scene.picture()
    np.testing.assert_array_equal(again[0], color)
    np.testing.assert_array_equal(again[1], depth)


def test_colours_are_read_as_mujoco_reads_them(scene: Scene) -> None:
    buffers = FrameBuffers(scene.context)
    buffers.use(*SIZE)
    color, _ = scene.picture()
    around = np.full((SIZE[1] + 4, SIZE[0] + 6, 3), 7, np.uint8)
    buffers.read_color(around[1 : SIZE[1] + 1, 2 : SIZE[0] + 2])
    np.testing.assert_array_equal(around[1 : SIZE[1] + 1, 2 : SIZE[0] + 2], color)
    around[1 : SIZE[1] + 1, 2 : SIZE[0] + 2] = 7
    assert (around == 7).all()  # nothing beside it was written


def test_each_size_has_its_own(scene: Scene) -> None:
    buffers = FrameBuffers(scene.context)
    buffers.use(*SIZE)
    small = scene.picture()
    buffers.use(2 * SIZE[0], 2 * SIZE[1])
    large = scene.picture(2 * SIZE[0], 2 * SIZE[1])
    buffers.use(*SIZE)
    np.testing.assert_array_equal(scene.picture()[0], small[0])
    np.testing.assert_allclose(large[0].mean((0, 1)), small[0].mean((0, 1)), atol=2)


def test_several_samples_per_pixel_are_drawn_in_mujocos_own() -> None:
    scene = Scene(samples=4)
    color, _ = scene.picture()
    buffers = FrameBuffers(scene.context)
    buffers.use(2 * SIZE[0], 2 * SIZE[1])
    assert (scene.context.offWidth, scene.context.offHeight) == (2 * SIZE[0], 2 * SIZE[1])
    assert scene.has_stencil()
    np.testing.assert_array_equal(scene.picture()[0], color)
    read = np.zeros_like(color)
    buffers.read_color(read)
    np.testing.assert_array_equal(read, color)
    scene.close()

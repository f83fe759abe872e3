"""The frame buffer without a stencil: smaller, and what is drawn and measured in it is the same."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from app.robots.simulated.depth_buffer import leave_out_stencil
from app.robots.simulated.gl import gl_environment
from tests.robots.conftest import needs_gl

SIZE = (96, 64)
_RENDERBUFFER, _STENCIL_BITS, _DEPTH_BITS = 0x8D41, 0x8D55, 0x8D54
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

    def picture(self) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        data, scene = mujoco.MjData(self.model), mujoco.MjvScene(self.model, maxgeom=10)
        mujoco.mj_forward(self.model, data)
        camera = mujoco.MjvCamera()
        mujoco.mjv_defaultFreeCamera(self.model, camera)
        every = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self.model, data, mujoco.MjvOption(), None, camera, every, scene)
        rectangle = mujoco.MjrRect(0, 0, *SIZE)
        mujoco.mjr_render(rectangle, scene, self.context)
        color, depth = np.zeros((SIZE[1], SIZE[0], 3), np.uint8), np.zeros((SIZE[1], SIZE[0]), np.float32)
        mujoco.mjr_readPixels(color, depth, rectangle, self.context)
        return color, depth

    def bits(self, which: int) -> int:
        """``_STENCIL_BITS`` or ``_DEPTH_BITS`` of the frame buffer."""
        library = ctypes.CDLL("libEGL.so.1")
        library.eglGetProcAddress.restype = ctypes.c_void_p
        bind = ctypes.CFUNCTYPE(None, ctypes.c_uint, ctypes.c_uint)(library.eglGetProcAddress(b"glBindRenderbuffer"))
        arguments = (ctypes.c_uint, ctypes.c_uint, ctypes.POINTER(ctypes.c_int))
        get = ctypes.CFUNCTYPE(None, *arguments)(library.eglGetProcAddress(b"glGetRenderbufferParameteriv"))
        found = ctypes.c_int(-1)
        bind(_RENDERBUFFER, self.context.offDepthStencil)
        get(_RENDERBUFFER, which, ctypes.byref(found))
        return found.value

    def close(self) -> None:
        self.context.free()
        self.gl.free()


@pytest.fixture
def scene() -> Iterator[Scene]:
    scene = Scene()
    yield scene
    scene.close()


def test_pictures_and_depths_are_the_same_without_a_stencil(scene: Scene) -> None:
    color, depth = scene.picture()
    assert color.std() > 10
    assert np.unique(depth).size > 100
    assert scene.bits(_STENCIL_BITS) == 8
    leave_out_stencil(scene.context)
    assert scene.bits(_STENCIL_BITS) == 0
    assert scene.bits(_DEPTH_BITS) == 32
    again = scene.picture()
    np.testing.assert_array_equal(again[0], color)
    np.testing.assert_array_equal(again[1], depth)


def test_another_size_is_drawn_without_a_stencil_too(scene: Scene) -> None:
    leave_out_stencil(scene.context)
    color, _ = scene.picture()
    mujoco.mjr_resizeOffscreen(2 * SIZE[0], 2 * SIZE[1], scene.context)
    leave_out_stencil(scene.context)
    assert scene.bits(_STENCIL_BITS) == 0
    np.testing.assert_array_equal(scene.picture()[0], color)


def test_several_samples_per_pixel_keep_their_stencil() -> None:
    scene = Scene(samples=4)
    color, _ = scene.picture()
    leave_out_stencil(scene.context)
    assert scene.bits(_STENCIL_BITS) == 8
    np.testing.assert_array_equal(scene.picture()[0], color)
    scene.close()

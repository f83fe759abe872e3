"""Frame buffers that fit what is drawn in them: one for each size of picture, without a stencil.

MuJoCo has one frame buffer, with depth and stencil in eight bytes per pixel, for reflections, which no camera here
draws. A software renderer moves every byte, and clears a part of a buffer by drawing over it, a whole one for nothing:
with depth alone, and in buffers of their own, pictures take two thirds of the time. They are the same bit by bit.
"""

from __future__ import annotations

import ctypes
import os
from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from app.robots.simulated.gl import UNUSABLE_GL, GlUnavailable

_FRAMEBUFFER, _RENDERBUFFER = 0x8D40, 0x8D41
_COLOR_ATTACHMENT, _DEPTH_ATTACHMENT = 0x8CE0, 0x8D00
_RGBA8, _DEPTH_COMPONENT32F = 0x8058, 0x8CAC
_COMPLETE = 0x8CD5
_RGBA, _UNSIGNED_BYTE = 0x1908, 0x1401


class FrameBuffers:
    """The frame buffers of ``context``, which is current whenever a method is called.

    Where OpenGL comes by another way than EGL, or several samples are drawn per pixel, MuJoCo's own one is enlarged.
    """

    def __init__(self, context: mujoco.MjrContext) -> None:
        self._context = context
        self._fit = os.environ.get("MUJOCO_GL") == "egl" and not context.offSamples
        self._first: int = context.offFBO
        self._made: dict[tuple[int, int], int] = {}
        self._read_into = np.zeros(0, dtype=np.uint8)
        if self._fit:
            integers = [ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_uint, ctypes.c_uint]
            self._read_pixels = _function("glReadPixels", *integers, ctypes.c_void_p)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, context)

    def use(self, width: int, height: int) -> None:
        """Have a picture of ``width`` x ``height`` (px) drawn and read at the lower left from now on; what was drawn
        before is lost. Raises GlUnavailable."""
        context = self._context
        if self._fit:
            if (width, height) not in self._made:
                self._made[width, height] = _make(width, height)
            context.offFBO = self._made[width, height]
        elif width > context.offWidth or height > context.offHeight:
            mujoco.mjr_resizeOffscreen(max(width, context.offWidth), max(height, context.offHeight), context)
        mujoco.mjr_restoreBuffer(context)

    def read_color(self, out: NDArray[np.uint8]) -> None:
        """Read the colours of the picture drawn last into ``out`` (H, W, 3), of its size, row 0 at the bottom."""
        height, width, _ = out.shape
        channels = 4 if self._fit else 3
        if self._read_into.size < channels * height * width:
            self._read_into = np.zeros(channels * height * width, dtype=np.uint8)
        read = self._read_into[: channels * height * width].reshape(height, width, channels)
        if self._fit:  # as they are stored: OpenCV converts them sooner than OpenGL
            self._read_pixels(0, 0, width, height, _RGBA, _UNSIGNED_BYTE, read.ctypes.data)
            cv2.cvtColor(read, cv2.COLOR_RGBA2RGB, dst=out)
        else:
            mujoco.mjr_readPixels(read, None, mujoco.MjrRect(0, 0, width, height), self._context)
            out[:] = read

    def free(self) -> None:
        """Free all of them, with their context."""
        self._context.offFBO = self._first  # the others go with OpenGL's context
        self._context.free()


def _make(width: int, height: int) -> int:
    """The number of a new frame buffer."""
    buffer = _name("glGenFramebuffers")
    _call("glBindFramebuffer", _FRAMEBUFFER, buffer)
    for attachment, kind in ((_COLOR_ATTACHMENT, _RGBA8), (_DEPTH_ATTACHMENT, _DEPTH_COMPONENT32F)):
        storage = _name("glGenRenderbuffers")
        _call("glBindRenderbuffer", _RENDERBUFFER, storage)
        _call("glRenderbufferStorage", _RENDERBUFFER, kind, width, height)
        _call("glFramebufferRenderbuffer", _FRAMEBUFFER, attachment, _RENDERBUFFER, storage)
    if (status := _call("glCheckFramebufferStatus", _FRAMEBUFFER)) != _COMPLETE:
        raise GlUnavailable(UNUSABLE_GL.format(why=f"a frame buffer of {width} x {height} is refused: {status:#x}"))
    return buffer


def _call(name: str, *arguments: int) -> int:
    """OpenGL's function ``name`` of unsigned ``arguments``."""
    return int(_function(name, *[ctypes.c_uint] * len(arguments))(*arguments))


def _name(generator: str) -> int:
    """One new number from OpenGL's ``generator``."""
    number = ctypes.c_uint()
    _function(generator, ctypes.c_int, ctypes.POINTER(ctypes.c_uint))(1, ctypes.byref(number))
    return number.value


def _function(name: str, *types: Any) -> Any:
    find = ctypes.CDLL("libEGL.so.1").eglGetProcAddress
    find.restype, find.argtypes = ctypes.c_void_p, (ctypes.c_char_p,)
    return ctypes.CFUNCTYPE(ctypes.c_uint, *types)(find(name.encode()))

"""The depth of MuJoCo's frame buffer without the stencil that comes with it.

MuJoCo asks for both in one (eight bytes per pixel), for reflections, which no camera here draws. A software renderer
moves every byte: without the stencil it rasterizes in three quarters of the time. Pictures and depths stay the same.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable

import mujoco

_FRAMEBUFFER, _RENDERBUFFER = 0x8D40, 0x8D41
_DEPTH_ATTACHMENT, _DEPTH_STENCIL_ATTACHMENT = 0x8D00, 0x821A
_DEPTH_COMPONENT32F, _DEPTH32F_STENCIL8 = 0x8CAC, 0x8CAD
_COMPLETE = 0x8CD5


def leave_out_stencil(context: mujoco.MjrContext) -> None:
    """Give the frame buffer of ``context``, which is current, a depth of four bytes per pixel; its content is lost.

    Where OpenGL comes by another way than EGL, does not draw without a stencil, or draws several samples per pixel, it
    stays.
    """
    if os.environ.get("MUJOCO_GL") != "egl" or context.offSamples:
        return
    allocate, attach = _function("glRenderbufferStorage", 4), _function("glFramebufferRenderbuffer", 4)
    depth, size = context.offDepthStencil, (context.offWidth, context.offHeight)
    _function("glBindFramebuffer", 2)(_FRAMEBUFFER, context.offFBO)
    _function("glBindRenderbuffer", 2)(_RENDERBUFFER, depth)
    attach(_FRAMEBUFFER, _DEPTH_STENCIL_ATTACHMENT, _RENDERBUFFER, 0)
    allocate(_RENDERBUFFER, _DEPTH_COMPONENT32F, *size)
    attach(_FRAMEBUFFER, _DEPTH_ATTACHMENT, _RENDERBUFFER, depth)
    if _function("glCheckFramebufferStatus", 1)(_FRAMEBUFFER) != _COMPLETE:
        allocate(_RENDERBUFFER, _DEPTH32F_STENCIL8, *size)
        attach(_FRAMEBUFFER, _DEPTH_STENCIL_ATTACHMENT, _RENDERBUFFER, depth)
    mujoco.mjr_restoreBuffer(context)


def _function(name: str, arguments: int) -> Callable[..., int]:
    """OpenGL's function ``name`` of so many unsigned ``arguments``, as MuJoCo's own context has found it."""
    find = ctypes.CDLL("libEGL.so.1").eglGetProcAddress
    find.restype, find.argtypes = ctypes.c_void_p, (ctypes.c_char_p,)
    return ctypes.CFUNCTYPE(ctypes.c_uint, *[ctypes.c_uint] * arguments)(find(name.encode()))

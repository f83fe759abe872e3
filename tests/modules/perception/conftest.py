"""What tests on rendered worlds need before anything imports mujoco, which reads it then."""

from __future__ import annotations

import os

from app.robots.simulated.gl import gl_environment

for name, value in gl_environment().items():
    os.environ.setdefault(name, value)

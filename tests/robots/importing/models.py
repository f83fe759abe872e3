"""Models of others, as they come: a base with an arm as URDF, and as MJCF."""

from __future__ import annotations

from pathlib import Path

import trimesh

URDF = """\
<robot name="Wheeled Arm">
  <gazebo reference="base"/>
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base"><visual><origin xyz="0 0 0.1"/><geometry><box size="0.4 0.3 0.1"/></geometry></visual></link>
  <joint name="left_wheel_joint" type="continuous">
    <parent link="base"/><child link="left_wheel"/><origin xyz="0 0.2 0.1"/><axis xyz="0 1 0"/>
  </joint>
  <link name="left_wheel"><visual><origin rpy="1.5707963 0 0"/>
    <geometry><cylinder radius="0.1" length="0.04"/></geometry>
  </visual></link>
  <joint name="laser_joint" type="fixed">
    <parent link="base"/><child link="base_laser"/><origin xyz="0.1 0 0.2"/><axis xyz="0 0 0"/>
  </joint>
  <link name="base_laser"/>
  <joint name="arm_1_joint" type="revolute">
    <parent link="base"/><child link="arm_1"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" velocity="0.5" effort="1"/>
  </joint>
  <link name="arm_1"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.05 0.05"/></geometry></collision></link>
  <joint name="arm_2_joint" type="revolute">
    <parent link="arm_1"/><child link="arm_2"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="3" effort="1"/>
  </joint>
  <link name="arm_2"><visual><geometry><mesh filename="package://wheeled_arm/meshes/hand.stl" scale="1 1 1"/></geometry>
  </visual></link>
  <joint name="lamp_joint" type="floating"><parent link="arm_2"/><child link="lamp"/></joint>
  <link name="lamp"><visual><geometry><mesh filename="package://wheeled_arm/meshes/lamp.step"/></geometry></visual>
  <collision><geometry><mesh filename="lost.stl"/></geometry></collision></link>
</robot>
"""

MJCF = """\
<mujoco model="arm">
  <compiler angle="radian"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="ball" pos="2 0 0.1"><freejoint/><geom type="sphere" size="0.1"/></body>
    <body name="base" pos="0 0 0.3">
      <freejoint/>
      <geom type="box" size="0.2 0.15 0.05" rgba="0 1 0 1"/>
      <geom type="cylinder" size="0.05 0.1" pos="0 0 0.1" group="3"/>
      <body name="shoulder" pos="0.1 0 0.1" quat="0.9238795 0 0 0.3826834">
        <joint name="yaw" type="hinge" axis="0 0 1" range="-1 1" pos="0.02 0 0"/>
        <joint name="pitch" type="hinge" axis="0 1 0" pos="0.02 0.01 0.03"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0.1" size="0.03"/>
        <body name="hand" pos="0.3 0 0.1" euler="0.3 0.2 0.1">
          <joint name="reach" type="slide" axis="1 0 0" range="0 0.2"/>
          <geom type="ellipsoid" size="0.05 0.03 0.02"/>
          <body name="thumb" pos="0.02 0.03 0">
            <joint name="thumb_joint" type="hinge" axis="0 0 1" range="-1 1"/><geom type="sphere" size="0.01"/>
          </body>
          <body name="tip" pos="0.05 0 0"><joint type="ball"/><geom type="sphere" size="0.01"/></body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="thumb_joint" joint2="pitch" polycoef="0.1 0.5 0 0 0"/></equality>
</mujoco>
"""


def write_urdf(folder: Path) -> Path:
    """The URDF in a package of its own, with one of its meshes."""
    package = folder / "wheeled_arm"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    (package / "meshes" / "hand.stl").write_bytes(
        trimesh.exchange.stl.export_stl(trimesh.creation.box((0.1, 0.1, 0.1)))
    )
    (package / "meshes" / "lamp.step").write_bytes(b"not read")
    path = package / "urdf" / "arm.urdf"
    path.write_text(URDF, "utf-8")
    return path


def write_mjcf(folder: Path) -> Path:
    path = folder / "arm.xml"
    path.write_text(MJCF, "utf-8")
    return path

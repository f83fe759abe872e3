"""The body in the world: the URDF attached with a free joint, its drives, servos and camera, and their addresses.

Links that joints of kinematic groups carry are left out: they have no mass, no contact, and no camera of the robot
draws them. Contacts are between robot and world only; the robot's visual shapes are group 1, its collision shapes group
3, so that the laser (which looks at group 0) never sees its own body and the camera draws the visual shapes alone.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.kinematic_model import KinematicModel, load_model
from app.robots.config import RobotConfig
from app.robots.guard import BaseVelocity
from app.robots.simulated.kinect_noise import camera_model
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.scenery.actor import Actor
from app.robots.simulated.scenery.people import add_people
from app.robots.simulated.world import ROBOT_CONTACT, TIMESTEP_S, WORLD_CONTACT, build_world
from app.robots.simulated.world_config import WorldConfig

PREFIX = "robot/"
VISUAL_GROUP, COLLISION_GROUP = 1, 3
_DRIVE_GAIN = 40.0
_WHEEL_ARMATURE = 0.08
_SERVO_ARMATURE = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class RobotSimulation:
    """A compiled world with the robot in it; ``joint_addresses`` (n,) are the places of ``joints`` in qpos.

    ``joints`` are those with physics; ``kinematic_joints`` of the robot are not among them.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    joints: tuple[str, ...]
    joint_addresses: NDArray[np.intp]
    left_wheel: int
    right_wheel: int
    base_address: int
    base_velocity: int
    base_body: int
    config: RobotConfig

    def drive(self, velocity: BaseVelocity) -> None:
        """Set the wheels' drives to the speeds of ``velocity`` on the nominal base."""
        base = self.config.base
        turn = velocity.angular_radps * base.track_m / 2
        self.data.ctrl[self.left_wheel] = (velocity.linear_mps - turn) / base.wheel_radius_m
        self.data.ctrl[self.right_wheel] = (velocity.linear_mps + turn) / base.wheel_radius_m

    def step(self) -> None:
        mujoco.mj_step(self.model, self.data)

    @property
    def time_s(self) -> float:
        """Simulated seconds since the start."""
        return float(self.data.time)

    def joint_positions(self) -> NDArray[np.float64]:
        """True positions of ``joints`` (rad or m)."""
        return np.asarray(self.data.qpos[self.joint_addresses])

    def true_pose(self) -> Pose2:
        """``X_WB`` in the plane."""
        x, y, _, w, qx, qy, qz = (float(v) for v in self.data.qpos[self.base_address : self.base_address + 7])
        return Pose2(x, y, math.atan2(2 * (w * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))

    def true_velocity(self) -> BaseVelocity:
        """Forward and turning speed of the base in its own frame."""
        vx, vy = (float(v) for v in self.data.qvel[self.base_velocity : self.base_velocity + 2])
        heading = self.true_pose().theta
        return BaseVelocity(
            vx * math.cos(heading) + vy * math.sin(heading), float(self.data.qvel[self.base_velocity + 5])
        )


def build_simulation(
    robot: RobotConfig, world: WorldConfig, base: TrueBase, people: Sequence[Actor] = ()
) -> RobotSimulation:
    """Build and compile the world with ``people`` and the robot at its start. ``base``: true geometry of its wheels.

    Raises ConfigError for a model that is no valid URDF or that the physics refuses.
    """
    spec = build_world(world)
    add_people(spec, people, world.seed)
    body = mujoco.MjSpec.from_file(str(robot.model))
    kinematics = load_model(robot.model)
    _leave_out(body, kinematics, robot.kinematic_joints)
    _tune(body, robot, base)
    _add_cameras(body, robot)
    X_WB = spec.worldbody.add_frame(
        pos=[robot.start.x, robot.start.y, 0.0],
        quat=[
            math.cos(math.radians(robot.start.heading_deg) / 2),
            0,
            0,
            math.sin(math.radians(robot.start.heading_deg) / 2),
        ],
    )
    root = X_WB.attach_body(body.body(kinematics.root), PREFIX, "")
    root.add_freejoint(name="base")
    try:
        model = spec.compile()
    except ValueError as failure:
        raise ConfigError(f"cannot be simulated: {failure}".replace("\n", "; "), str(robot.model)) from None
    wheels = (robot.base.left_wheel_joint, robot.base.right_wheel_joint)
    _limit_drives(model, wheels, robot, base)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    free = model.joint("base")
    joints = tuple(name for name in kinematics.joint_names if name not in robot.kinematic_joints)
    return RobotSimulation(
        model=model,
        data=data,
        joints=joints,
        joint_addresses=np.array([model.joint(PREFIX + name).qposadr[0] for name in joints]),
        left_wheel=model.actuator(PREFIX + wheels[0]).id,
        right_wheel=model.actuator(PREFIX + wheels[1]).id,
        base_address=int(free.qposadr[0]),
        base_velocity=int(free.dofadr[0]),
        base_body=int(free.bodyid[0]),
        config=robot,
    )


def _leave_out(body: mujoco.MjSpec, kinematics: KinematicModel, joints: Collection[str]) -> None:
    """Remove the links that ``joints``, or joints that mimic them, carry, with all that is on them."""
    left_out = {name for name, joint in kinematics.joints.items() if name in joints or joint.mimic in joints}
    while (carrier := next((joint for joint in body.joints if joint.name in left_out), None)) is not None:
        body.delete(carrier.parent)


def _tune(body: mujoco.MjSpec, robot: RobotConfig, base: TrueBase) -> None:
    """Contacts, groups, drives and servos; true wheels."""
    for geom in body.geoms:
        if geom.contype == 0:
            geom.group = VISUAL_GROUP
            continue
        geom.group = COLLISION_GROUP
        geom.contype, geom.conaffinity = ROBOT_CONTACT, WORLD_CONTACT
        if geom.type == mujoco.mjtGeom.mjGEOM_SPHERE:  # ball casters: they carry, and roll any way
            geom.friction = [0.01, 0.0001, 0.0001]
            geom.priority = 1
            geom.condim = 3
    wheels = {
        robot.base.left_wheel_joint: (base.left_radius_m, base.track_m / 2),
        robot.base.right_wheel_joint: (base.right_radius_m, -base.track_m / 2),
    }
    followers = {equality.name1 for equality in body.equalities}
    for joint in body.joints:
        if joint.name in followers:
            continue  # MuJoCo's constraint moves a joint that mimics another
        actuator = body.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        if joint.name in wheels:
            radius, y = wheels[joint.name]
            actuator.set_to_velocity(kv=_DRIVE_GAIN)
            joint.armature = _WHEEL_ARMATURE
            wheel = joint.parent
            # On the floor with the casters, however large: or these would carry the body, and the wheels spin.
            wheel.pos = [wheel.pos[0], y, wheel.pos[2] + radius - robot.base.wheel_radius_m]
            for geom in wheel.geoms:
                if geom.contype:
                    geom.size = [radius, geom.size[1], 0]
                    geom.friction = [0.9, 0.005, 0.0001]
                    geom.priority = 2
        else:
            actuator.set_to_position(kp=120.0, kv=12.0)
            joint.armature = _SERVO_ARMATURE
    commanded = {name for actuator in robot.actuators.values() for name in actuator.joints}
    for joint in body.joints:
        if joint.name in commanded:
            for carried in (joint.parent, *joint.parent.find_all(mujoco.mjtObj.mjOBJ_BODY)):
                carried.gravcomp = 1.0  # else it sags, and creeps for seconds after each move


def _add_cameras(body: mujoco.MjSpec, robot: RobotConfig) -> None:
    # MuJoCo's cameras look along -z with y up: half a turn about x from the optical frame
    turned = [0.0, 1.0, 0.0, 0.0]
    kinect, panorama = robot.streams.kinect, robot.streams.panorama
    if kinect is not None:
        lens = camera_model(kinect)
        body.body(kinect.link).add_camera(
            name="kinect",
            quat=turned,
            resolution=[lens.width, lens.height],
            sensor_size=[lens.width / lens.fx, lens.height / lens.fy],
            focal_length=[1.0, 1.0],
        )
    if panorama is not None:  # a fisheye is more than MuJoCo's camera can be: only its place
        body.body(panorama.link).add_camera(name="panorama", quat=turned)


def _limit_drives(model: mujoco.MjModel, wheels: tuple[str, str], robot: RobotConfig, base: TrueBase) -> None:
    """Torque limits such that a safety stop brakes the whole robot with ``emergency_mps2``."""
    mass = float(model.body_subtreemass[model.joint("base").bodyid[0]])
    for wheel, radius in zip(wheels, (base.left_radius_m, base.right_radius_m), strict=True):
        actuator = model.actuator(PREFIX + wheel).id
        torque = (mass / 2 + _WHEEL_ARMATURE / radius**2) * robot.limits.emergency_mps2 * radius
        model.actuator_forcelimited[actuator] = 1
        model.actuator_forcerange[actuator] = (-torque, torque)


__all__ = ["TIMESTEP_S", "RobotSimulation", "build_simulation"]

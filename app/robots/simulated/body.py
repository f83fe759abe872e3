"""The body in the world: the URDF attached with a free joint, its drives, servos and camera, and their addresses.

Links that joints of kinematic groups carry are left out: they have no mass, no contact, and no camera of the robot
draws them. Contacts are between robot and world only; the robot's visual shapes are group 1, its collision shapes group
3, so that the laser (which looks at group 0) never sees its own body and the camera draws the visual shapes alone.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Iterable, Sequence
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
_CASTER_FRICTION = [0.01, 0.0001, 0.0001]
_HOLONOMIC_GAIN = 50.0
"""1/s: how fast a holonomic drive corrects its velocity, within its greatest force."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotSimulation:
    """A compiled world with the robot in it; ``joint_addresses`` (n,) are the places of ``joints`` in qpos,
    ``joint_velocities`` (n,) those in qvel.

    ``joints`` are those with physics; ``kinematic_joints`` of the robot are not among them.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    joints: tuple[str, ...]
    joint_addresses: NDArray[np.intp]
    joint_velocities: NDArray[np.intp]
    left_wheel: int
    right_wheel: int
    base_address: int
    base_velocity: int
    base_body: int
    config: RobotConfig
    #: Mass (kg) and moment of inertia about the base's vertical axis (kg m^2) of the whole robot, as built.
    inertia: tuple[float, float]

    def drive(self, velocity: BaseVelocity) -> None:
        """Set the drives to ``velocity``: the wheels to its speeds on the nominal base, or the forces of a holonomic
        drive for this step. A differential drive ignores the sideways part."""
        base = self.config.base
        if base.drive == "holonomic":
            self._push(velocity)
            return
        turn = velocity.angular_radps * base.track_m / 2
        self.data.ctrl[self.left_wheel] = (velocity.linear_mps - turn) / base.wheel_radius_m
        self.data.ctrl[self.right_wheel] = (velocity.linear_mps + turn) / base.wheel_radius_m

    def _push(self, velocity: BaseVelocity) -> None:
        """Apply at the floor, as wheels do, the force and torque towards ``velocity``, no more than brakes the robot
        with ``emergency_mps2``."""
        mass, inertia = self.inertia
        most_mps2, now = self.config.limits.emergency_mps2, self.true_velocity()
        error = complex(velocity.linear_mps - now.linear_mps, velocity.lateral_mps - now.lateral_mps)
        push = error * min(_HOLONOMIC_GAIN, most_mps2 / max(abs(error), 1e-9))
        push *= mass * cmath.rect(1.0, self.true_pose().theta)
        most_radps2 = most_mps2 / (self.config.base.track_m / 2)
        turn = _HOLONOMIC_GAIN * (velocity.angular_radps - now.angular_radps)
        turn = inertia * min(max(turn, -most_radps2), most_radps2)
        first = self.base_velocity
        self.data.qfrc_applied[first : first + 2] = push.real, push.imag
        self.data.qfrc_applied[first + 5] = turn

    def step(self) -> None:
        mujoco.mj_step(self.model, self.data)

    @property
    def time_s(self) -> float:
        """Simulated seconds since the start."""
        return float(self.data.time)

    def joint_positions(self) -> NDArray[np.float64]:
        """True positions of ``joints`` (rad or m)."""
        return np.asarray(self.data.qpos[self.joint_addresses])

    def joint_numbers(self, names: Iterable[str]) -> NDArray[np.intp]:
        """The places (n,) in ``joints`` of those named."""
        return np.array([self.joints.index(name) for name in names], dtype=np.intp)

    def motor_efforts(self) -> NDArray[np.float64]:
        """What the motors of ``joints`` exerted in the last step (N m, N where prismatic), without what compensates
        the weight that they carry."""
        return np.asarray(self.data.qfrc_actuator[self.joint_velocities])

    def external_efforts(self) -> NDArray[np.float64]:
        """What ``joints`` feel from outside (N m, N where prismatic): what neither motor nor damping accounts for, as
        far as they do not accelerate; friction is part of it."""
        dofs = self.joint_velocities
        resisting = self.data.qfrc_actuator[dofs] - self.model.dof_damping[dofs] * self.data.qvel[dofs]
        return np.asarray(-resisting)

    def motor_power_w(self) -> float:
        """Mechanical power (W) that the motors of wheels and joints put out now; what they brake is lost."""
        power = self.data.actuator_force * self.data.actuator_velocity
        return float(np.maximum(power, 0.0).sum())

    def true_pose(self) -> Pose2:
        """``X_WB`` in the plane."""
        x, y, _, w, qx, qy, qz = self.data.qpos[self.base_address : self.base_address + 7].tolist()
        return Pose2(x, y, math.atan2(2 * (w * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))

    def true_velocity(self) -> BaseVelocity:
        """Velocity of the base in its own frame."""
        vx, vy, _, _, _, turn = self.data.qvel[self.base_velocity : self.base_velocity + 6].tolist()
        heading = self.true_pose().theta
        c, s = math.cos(heading), math.sin(heading)
        return BaseVelocity(vx * c + vy * s, turn, vy * c - vx * s)


def build_simulation(
    robot: RobotConfig, world: WorldConfig, base: TrueBase, people: Sequence[Actor] = ()
) -> RobotSimulation:
    """Build and compile the world with ``people`` and the robot at its start. ``base``: true geometry of its wheels.

    Raises ConfigError for a model that is no valid URDF or that the physics refuses.
    """
    streams = robot.streams
    seen = streams.kinect is not None or streams.panorama is not None
    spec = build_world(world, textured=seen)
    add_people(spec, people, world.seed, textured=seen)
    body = mujoco.MjSpec.from_file(str(robot.model))
    kinematics = load_model(robot.model)
    _leave_out(body, kinematics, robot.kinematic_joints)
    _tune(body, robot, base, kinematics)
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
        joint_velocities=np.array([model.joint(PREFIX + name).dofadr[0] for name in joints]),
        left_wheel=model.actuator(PREFIX + wheels[0]).id,
        right_wheel=model.actuator(PREFIX + wheels[1]).id,
        base_address=int(free.qposadr[0]),
        base_velocity=int(free.dofadr[0]),
        base_body=int(free.bodyid[0]),
        config=robot,
        inertia=_inertia(model, data, int(free.dofadr[0])),
    )


def _inertia(model: mujoco.MjModel, data: mujoco.MjData, first: int) -> tuple[float, float]:
    matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, matrix)
    return float(matrix[first, first]), float(matrix[first + 5, first + 5])


def _leave_out(body: mujoco.MjSpec, kinematics: KinematicModel, joints: Collection[str]) -> None:
    """Remove the links that ``joints``, or joints that mimic them, carry, with all that is on them."""
    left_out = {
        name
        for name, joint in kinematics.joints.items()
        if name in joints or (joint.mimic is not None and joint.mimic.joint in joints)
    }
    while (carrier := next((joint for joint in body.joints if joint.name in left_out), None)) is not None:
        body.delete(carrier.parent)


def _tune(body: mujoco.MjSpec, robot: RobotConfig, base: TrueBase, kinematics: KinematicModel) -> None:
    """Contacts, groups, drives and servos; true wheels."""
    differential = robot.base.drive == "differential"
    for geom in body.geoms:
        if geom.contype == 0:
            geom.group = VISUAL_GROUP
            continue
        geom.group = COLLISION_GROUP
        geom.contype, geom.conaffinity = ROBOT_CONTACT, WORLD_CONTACT
        if geom.type == mujoco.mjtGeom.mjGEOM_SPHERE:  # ball casters: they carry, and roll any way
            geom.friction = _CASTER_FRICTION
            geom.priority = 1
            geom.condim = 3
    wheels = {
        robot.base.left_wheel_joint: (base.left_radius_m, base.track_m / 2),
        robot.base.right_wheel_joint: (base.right_radius_m, -base.track_m / 2),
    }
    for joint in body.joints:
        if joint.name not in kinematics.joint_names:
            continue  # MuJoCo's constraint moves a joint that mimics another
        actuator = body.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        if joint.name in wheels:
            radius, y = wheels[joint.name]
            actuator.set_to_velocity(kv=_DRIVE_GAIN if differential else 0.0)
            joint.armature = _WHEEL_ARMATURE
            wheel = joint.parent
            # On the floor with the casters, however large: or these would carry the body, and the wheels spin.
            wheel.pos = [wheel.pos[0], y, wheel.pos[2] + radius - robot.base.wheel_radius_m]
            for geom in wheel.geoms:
                if geom.contype:
                    geom.size = [radius, geom.size[1], 0]
                    geom.friction = [0.9, 0.005, 0.0001] if differential else _CASTER_FRICTION
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

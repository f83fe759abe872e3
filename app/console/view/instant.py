"""The instant at which body and head are drawn: one for both, so that neither has another instant's pose."""

from __future__ import annotations

from app.base.joint_buffer import JointBuffer

#: Joints that are further behind odometry (s) are drawn as they were said last: their source is slow, or has stopped.
BEHIND_S = 0.1
#: A joint that moves faster (rad/s, m/s) would be seen to lag.
STILL = 0.02


def drawn_instant(odometry: float, joints: JointBuffer) -> float:
    """Odometry's newest stamp (s); while a joint moves, that of the joints, where odometry, which comes more often, is
    ahead of them. A head that turns at 60°/s is 2° further after one period of 30 Hz."""
    newest = joints.newest_stamp
    if newest is None or newest >= odometry or odometry - newest > BEHIND_S or joints.speed() <= STILL:
        return odometry
    return newest

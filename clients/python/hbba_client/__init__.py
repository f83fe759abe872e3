"""Client of an HBBA console: what REST and the live stream offer, typed.

``Robot`` is called, ``AsyncRobot`` is awaited; both have one method for each operation of REST, ``desire`` for a desire
that lasts as long as a block, and ``live`` for the live stream. Records are in ``hbba_client.records``.
"""

from .async_robot import AsyncHeldDesire, AsyncRobot
from .request import Problem, Unreachable
from .robot import HeldDesire, Robot

__all__ = ["AsyncHeldDesire", "AsyncRobot", "HeldDesire", "Problem", "Robot", "Unreachable"]

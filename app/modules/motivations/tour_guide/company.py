"""Who comes along on a tour: how many, and how far behind they may be. Pure functions on frozen values.

The robot sees only ahead. So it reckons that who follows may have stopped where all of them were seen last.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from app.tours.model import Pace

if TYPE_CHECKING:
    from app.modules.motivations.tour_guide.progress import View

#: It looks back once a visitor may have been farther behind than ``wait_m`` for so long (s).
MAY_BE_FAR_S: Final = 8.0
#: Before it takes visitors for gone, it looks in so many directions: the camera that sees farthest sees 57 degrees.
DIRECTIONS: Final = 6
#: Visitors whose distance changes by no more (m) stand.
_STEP_M: Final = 0.2
#: Who is farther away than as it set out by more (m) falls behind.
_STAND_M: Final = 0.5
#: All were seen where it is if it has driven no farther since (m).
_HERE_M: Final = 0.5


@dataclass(frozen=True, slots=True)
class Company:
    """Those who come along.

    ``size``: how many they are, as far as was seen; ``met``: whether any was seen on this run. ``seen_m``: ``driven_m``
    when all were seen last, the farthest ``apart_m`` (m) away, and ``stood_m`` (m) as it set out; ``far_since``:
    since when (s) one may be farther than ``wait_m``. ``sought_since``: since when (s) it waits for them or looks
    for them, ``looked``: whether it has looked along its way since, ``went_back``: whether it drove back meanwhile;
    ``farthest_m``, ``moved_at``: the distance of the farthest (m), and when (s) it changed last; ``short``: not all
    are there, as far as is known. ``last_look``: it has waited long enough, and has looked in so many directions all
    around since, the next from ``look_at`` (s) on, the first towards ``look_from`` (rad in odom); None before;
    ``around``: how many were there at once meanwhile.
    """

    size: int = 0
    met: bool = False
    seen_m: float = 0.0
    apart_m: float = 0.0
    stood_m: float = 0.0
    far_since: float | None = None
    sought_since: float | None = None
    looked: bool = False
    went_back: bool = False
    farthest_m: float = 0.0
    moved_at: float = 0.0
    short: bool = False
    last_look: int | None = None
    look_at: float = 0.0
    look_from: float = 0.0
    around: int = 0


NOBODY: Final = Company()


def noted(company: Company, view: View, pace: Pace, *, counts: bool) -> Company:
    """``company`` after ``view``; ``counts``: people who are seen now come along."""
    company = replace(company, met=company.met or view.people > 0)
    if counts:
        company = replace(company, size=max(company.size, view.people))
    all_there = view.there >= max(company.size, 1)
    company = replace(company, short=not (all_there and company.looked))
    if all_there and view.there_m <= pace.wait_m:
        company = replace(company, seen_m=view.driven_m, apart_m=view.there_m)
    if abs(view.there_m - company.farthest_m) > _STEP_M:
        company = replace(company, farthest_m=view.there_m, moved_at=view.now)
    far = company.apart_m + view.driven_m - company.seen_m > pace.wait_m
    since = view.now if company.far_since is None else company.far_since
    return replace(company, far_since=since if far else None)


def set_out(company: Company, view: View, pace: Pace) -> Company:
    """``company`` as the robot begins to lead; those whom it does not see may be as far as it lets them be."""
    seen = view.driven_m - company.seen_m <= _HERE_M and company.met
    apart_m = company.apart_m if seen else pace.wait_m
    return replace(
        company,
        seen_m=view.driven_m,
        apart_m=apart_m,
        stood_m=apart_m if seen else 0.0,
        far_since=None,
        sought_since=None,
        looked=False,
        went_back=False,
        last_look=None,
        around=0,
    )


def falls_behind_m(company: Company, pace: Pace) -> float:
    """Who is farther away (m) is slowed down for: those who stood behind one another have not fallen behind."""
    return max(pace.slow_m, company.stood_m + _STAND_M)


def looks_back(company: Company, view: View, pace: Pace) -> bool:
    """Whether it is time to look back."""
    may_be_far = company.far_since is not None and view.now - company.far_since >= MAY_BE_FAR_S
    return may_be_far or view.driven_m - company.seen_m >= pace.look_back_m

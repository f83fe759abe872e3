"""Looking back for visitors, waiting for them, and driving back for those who are missing. Pure functions.

Who follows the robot is behind it, where it sees nothing, also while it drives back. So no visitor is taken for gone
before it has called, and looked all around from where it is.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from app.base.geometry import wrap_angle
from app.modules.motivations.tour_guide.company import DIRECTIONS, set_out
from app.modules.motivations.tour_guide.entering import enter, part
from app.modules.motivations.tour_guide.progress import Progress, View
from app.tours.model import Pace

#: Turned to where they come from, it has looked after so long (s).
LOOKED_S: Final = 1.5
#: In one direction it looks for so long (s), turning among it; then into the opposite one, and so on.
LOOKS_S: Final = 8.0
#: Somebody whose face is not seen has turned away, and is waited for so long (s) before it goes on.
TURNED_AWAY_S: Final = 6.0
#: After so long (s) it drives back for who is missing, and where it sees no visitor.
GOES_BACK_S: Final = 16.0
GOES_BACK_FOR_ALL_S: Final = 8.0
#: Farther (m) from the way that it came, it is driving back another way: it would lead visitors who follow away.
ASTRAY_M: Final = 1.0
_BETWEEN_RAD: Final = 2 * math.pi / DIRECTIONS
#: Visitors who come no nearer for so long (s) stand behind one another.
STAND_S: Final = 2.0


def wait(progress: Progress, view: View, reason: str) -> Progress:
    """Waiting for visitors, for ``reason``."""
    company = progress.company
    since = view.now if company.sought_since is None else company.sought_since
    company = replace(company, sought_since=since, moved_at=view.now)
    return enter(replace(progress, company=company), "waiting", view, reason=reason)


def waited(progress: Progress, view: View, pace: Pace) -> Progress:
    """On once all who came along are near; back for those who are not seen; on without them in the end."""
    company, spent = progress.company, view.now - progress.since
    looked = company.looked or view.looked_s >= LOOKED_S or spent >= LOOKS_S
    missing = view.there < max(company.size, 1)
    stand = view.now - company.moved_at >= STAND_S
    near = view.there_m <= pace.slow_m or (view.next_m <= pace.slow_m and view.there_m <= pace.wait_m and stand)
    comes = view.faces >= max(company.size, 1) or spent >= TURNED_AWAY_S
    if looked and not missing and near and comes:
        return _on(progress, view, pace)
    progress = replace(progress, company=replace(company, looked=looked))
    if _is_over(progress, view, pace):
        return _looked_all_around(progress, view, pace) if missing else _on_without(progress, view, pace)
    patience_s = GOES_BACK_FOR_ALL_S if view.there == 0 else GOES_BACK_S
    if missing and view.back is not None and not company.went_back and spent >= patience_s:
        gone = replace(progress, company=replace(progress.company, went_back=True), back=view.back)
        return enter(gone, "searching", view, reason=_missing(progress, view))
    return replace(progress, reason=_missing(progress, view)) if missing and looked and spent >= LOOKS_S else progress


def searched(progress: Progress, view: View, pace: Pace) -> Progress:
    """Driving back until all are seen, along the way that it came, until it has waited long enough."""
    if view.there >= max(progress.company.size, 1) and view.there_m <= pace.wait_m:
        return wait(progress, view, "visitors are found")
    if _is_over(progress, view, pace):
        return wait(progress, view, _missing(progress, view))
    return wait(progress, view, "visitors are in its way back") if view.astray_m > ASTRAY_M else progress


def looks_towards(progress: Progress, view: View) -> float | None:
    """Where it turns to while it waits (rad in odom): to visitors; while one is missing, to where they come from, and
    to the other side by turns; where no visitor is seen in either, all around by quarters. In the end, all around."""
    company = progress.company
    if company.last_look is not None:
        answers = view.people + view.others == 0 and view.speaking
        return view.towards if answers else wrap_angle(company.look_from + company.last_look * _BETWEEN_RAD)
    if not company.short:
        return view.towards
    turn = math.floor((view.now - progress.since) / LOOKS_S)
    if view.people + view.others == 0 and turn >= (1 if view.behind is None else 2):
        begin = next((heading for heading in (view.behind, view.towards) if heading is not None), 0.0)
        return wrap_angle(begin + turn * math.pi / 2)
    if turn % 2 and view.behind is not None:
        return wrap_angle(view.behind + math.pi)
    return view.towards if view.people == 0 or view.behind is None else view.behind


def _is_over(progress: Progress, view: View, pace: Pace) -> bool:
    since = progress.company.sought_since
    return view.now - (progress.since if since is None else since) >= pace.give_up_s


def _looked_all_around(progress: Progress, view: View, pace: Pace) -> Progress:
    """Without those who are missing once it has called, and looked in all directions."""
    looks, around = progress.company.last_look, max(progress.company.around, view.there)
    company = replace(progress.company, around=around, look_at=view.now)
    if looks is None:
        company = replace(company, last_look=0, look_from=_behind_it(progress, view))
        reason = f"{_missing(progress, view)}; it looks all around"
        return enter(replace(progress, company=company), "waiting", view, reason=reason)
    # It may have been turned there before, or cannot turn there.
    spent = view.now - progress.company.look_at
    if min(view.looked_s, spent) < LOOKED_S and spent < LOOKS_S:
        return replace(progress, company=replace(progress.company, around=around))
    if looks + 1 >= DIRECTIONS:
        return _on_without(replace(progress, company=company), view, pace)
    return replace(progress, company=replace(company, last_look=looks + 1))


def _behind_it(progress: Progress, view: View) -> float:
    """The heading (rad in odom) of those who follow, as far as is known: away from where it looks or drives."""
    ahead = next((each for each in (progress.towards, view.behind) if each is not None), 0.0)
    return wrap_angle(ahead + math.pi)


def _on(progress: Progress, view: View, pace: Pace) -> Progress:
    apart_m = min(view.there_m, pace.wait_m) if view.there else pace.wait_m
    company = replace(set_out(progress.company, view, pace), apart_m=apart_m, stood_m=apart_m)
    return enter(replace(progress, company=company, slow=False), "leading", view)


def _on_without(progress: Progress, view: View, pace: Pace) -> Progress:
    there = _there(progress, view)
    if there == 0:
        return part(progress, view, "all visitors have left")
    reason, missing = _missing(progress, view), there < progress.company.size
    ahead = _on(replace(progress, company=replace(progress.company, size=there)), view, pace)
    return replace(ahead, excuse="without", reason=f"{reason}; it goes on") if missing else ahead


def _there(progress: Progress, view: View) -> int:
    """How many are there, or were as it looked all around."""
    return max(view.there, progress.company.around)


def _missing(progress: Progress, view: View) -> str:
    size, there = max(progress.company.size, 1), _there(progress, view)
    return "no visitor is seen" if there == 0 else f"{there} of {size} visitors are seen"

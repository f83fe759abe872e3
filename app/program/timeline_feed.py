"""Events of the program on the timeline, beside those of attention: modules, guard, exploitation, overload, stale
channels, percept events.

A bad state is noted once on entering and once on leaving, never in between.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from app.attention.activity import GROUP
from app.attention.desire_progress import Waiting
from app.attention.exploitation import ExploitationChange
from app.attention.timeline import Timeline
from app.messages import GroupStatus, LinkStatus, PerceptEvent, PerceptKind
from app.runtime.freshness import Freshness
from app.runtime.load import CpuLoad
from app.runtime.supervisor import ModuleState

#: Load windows (1 s each) in a row over budget before it is called overload: start-up bursts are none.
OVERLOAD_WINDOWS = 3

#: Looks (1 s apart) in a row at a channel that is stale before it is noted: a hiccup is none.
STALE_LOOKS = 2

#: Below this share of real time the simulated world is slow, when it lasts (s); it is well again when that lasts.
SLOW_WORLD = 0.95
SLOW_AFTER_S = 3.0
WELL_AFTER_S = 10.0

#: Joints whose commands were refused are well when they have followed them for so long (s).
FOLLOWS_AFTER_S = 2.0

_GUARD_WORDS = {
    "idle": "The base rests",
    "driving": "The base drives",
    "stale_command": "The guard stopped the base",
    "e_stopped": "Emergency stop",
    "sensor_failure": "The guard holds the base",
}


#: What people read of a percept that is there, by kind; of the others, kind and subject.
_PERCEPT_WORDS = {"code": "QR code {subject}", "noise": "loud noise"}


#: What is said of those who are exploited, by group; of others, that they move the group.
_DOES = {"base": "drives", GROUP: "perceives"}


class TimelineFeed:
    """Turns states into timeline events, one for each change."""

    def __init__(
        self, timeline: Timeline, budgets: Mapping[str, float], percept_kinds: Iterable[PerceptKind] = ()
    ) -> None:
        """``budgets``: the CPU (% of one core) each module is expected to stay under. ``percept_kinds``: those that
        message types declare."""
        self._timeline = timeline
        self._budgets = dict(budgets)
        self._percept_words = _PERCEPT_WORDS | {kind.name: kind.words for kind in percept_kinds}
        self.reset()

    def reset(self) -> None:
        """Clear the known states: the next report of each is an event again."""
        self._guard = ""
        self._slow_world = False
        self._world_turned: float | None = None
        #: Groups of joints that refuse commands, and since when (s) they follow them again, or None.
        self._refused: dict[str, float | None] = {}
        self._stale: dict[str, int] = {}
        self._over = dict.fromkeys(self._budgets, 0)

    def module(self, state: ModuleState) -> None:
        """A module's state changed."""
        data = {"status": state.status, "restarts": state.restarts, "problem": state.problem}
        if state.status in ("failed", "hung"):
            self._timeline.add("module", state.name, f"{state.name} {state.status}: {state.problem}", data)
        elif state.status == "running" and state.restarts:
            self._timeline.add("restart", state.name, f"{state.name} runs again (restart {state.restarts})", data)

    def guard(self, status: LinkStatus) -> None:
        """The link reported; noted when the guard's state changes, joints begin or cease to refuse commands, or the
        world begins or ceases to run slowly."""
        if status.guard != self._guard:
            self._guard = status.guard
            words = _GUARD_WORDS.get(status.guard, status.guard)
            said = status.reason.lower().startswith(words.lower())
            text = f"{words}: {status.reason}" if status.reason and not said else words + status.reason[len(words) :]
            self._timeline.add("guard", status.guard, text, {"e_stopped": status.e_stopped})
        for group in status.groups:
            self._joints(group, status.stamp)
        self._world(status)

    def _joints(self, group: GroupStatus, now: float) -> None:
        name, data = group.group, {"group": group.group, "guard": group.guard}
        if group.guard == "refused":
            if name not in self._refused:
                self._timeline.add("guard", name, f"The {name.replace('_', ' ')} does not follow: {group.reason}", data)
            self._refused[name] = None
        elif name in self._refused and group.guard != "moving":
            self._refused[name] = None
        elif name in self._refused:
            since = self._refused[name]
            if since is None:
                self._refused[name] = now
            elif now - since >= FOLLOWS_AFTER_S:
                del self._refused[name]
                self._timeline.add("guard", name, f"The {name.replace('_', ' ')} follows commands again", data)

    def _world(self, status: LinkStatus) -> None:
        slow = status.world_rate < SLOW_WORLD
        if slow == self._slow_world:
            self._world_turned = None
            return
        if self._world_turned is None:
            self._world_turned = status.stamp
        if status.stamp - self._world_turned >= (SLOW_AFTER_S if slow else WELL_AFTER_S):
            self._slow_world, self._world_turned = slow, None
            text = (
                f"The simulated world runs at {status.world_rate:.2f} of real time: this computer is too slow for it"
                if slow
                else "The simulated world keeps real time again"
            )
            self._timeline.add("overload", "world", text, {"world_rate": status.world_rate})

    def exploitation(self, change: ExploitationChange, classes: Collection[str]) -> None:
        """A behavior began or ceased to command its group, for desires of ``classes``."""
        does = _DOES.get(change.group, f"moves the {change.group}")
        text = f"{change.behavior} {does}"
        data = {"group": change.group, "exploited": change.exploited, "classes": sorted(classes)}
        text = text if change.exploited else f"{text} no more"
        self._timeline.add("exploitation", change.behavior, text, data)

    def idle(self, waiting: Waiting) -> None:
        """A desire is intended, and has not been exploited for a while."""
        cls = waiting.desire.cls
        text = f"{cls} is intended and has not been exploited for {waiting.idle_s:.0f} s"
        data = {"id": waiting.desire.id, "exploited": False, "classes": [cls], "idle_s": round(waiting.idle_s, 1)}
        self._timeline.add("exploitation", cls, text, data)

    def percept(self, event: PerceptEvent) -> None:
        """Something perceived appeared, left or changed: noted under the event's name."""
        words = self._percept_words.get(event.kind)
        label = f"{event.kind} {event.subject}".rstrip() if words is None else words.format(subject=event.subject)
        data = {
            "label": label,
            "kind": event.kind,
            "subject": event.subject,
            "source": event.source,
            "since": event.since,
            "confidence": round(event.confidence, 3),
            "p_OP": None if event.p_OP is None else [round(value, 3) for value in event.p_OP],
            "heading": None if event.heading is None else round(event.heading, 3),
        }
        self._timeline.add("percept", event.name, _percept_words(label, event), data, stamp=event.stamp)

    def freshness(self, channels: Mapping[str, Freshness]) -> None:
        """The channels as they are now, by name; noted when one stays stale, and when it is so no longer."""
        for name, now in channels.items():
            looks = self._stale.get(name, 0)
            self._stale[name] = looks + 1 if now.state == "stale" else 0
            entered = self._stale[name] == STALE_LOOKS
            left = self._stale[name] == 0 and looks >= STALE_LOOKS
            if not entered and not left:
                continue
            data = {
                "state": now.state,
                "age_s": None if now.age_s is None else round(now.age_s, 3),
                "limit_s": None if now.limit_s is None else round(now.limit_s, 3),
                "rate_hz": None if now.rate_hz is None else round(now.rate_hz, 2),
                "commanded_hz": None if now.commanded_hz is None else round(now.commanded_hz, 2),
            }
            self._timeline.add("stale", name, _freshness_words(name, now), data)

    def load(self, load: CpuLoad) -> None:
        """A load window closed; noted when a module goes over its budget for good, and when it is back."""
        for name, budget in self._budgets.items():
            used = load.modules.get(name, 0.0)
            windows = self._over[name]
            if used > budget:
                self._over[name] = windows + 1
                if windows + 1 == OVERLOAD_WINDOWS:
                    text = f"{name} uses {used:.0f} % of a core, {budget:.0f} % is its budget"
                    self._timeline.add("overload", name, text, {"used": round(used, 1), "budget": budget})
            else:
                self._over[name] = 0
                if windows >= OVERLOAD_WINDOWS:
                    self._timeline.add("overload", name, f"{name} is within its budget again", {"used": round(used, 1)})


def _percept_words(label: str, event: PerceptEvent) -> str:
    text = f"{label[0].upper()}{label[1:]} {event.name.rpartition('.')[2]}"
    return text if event.p_OP is None else f"{text} at x {event.p_OP[0]:.1f} m, y {event.p_OP[1]:.1f} m in odom"


def _freshness_words(name: str, now: Freshness) -> str:
    if now.state == "closed":
        return f"{name} is no longer stale: no subscription is open any more"
    if now.state != "stale":
        return f"{name} is up to date again"
    age = "nothing has come yet" if now.age_s is None else f"its newest message is {now.age_s:.2f} s old"
    if now.limit_s is None:
        return f"{name} is stale: {age} and the module behind it does not run, so nothing new can come"
    allowed = f"{now.limit_s:.2f} s allowed at the {now.commanded_hz:g} messages a second asked for"
    return f"{name} is stale: {age}, {allowed}; whatever builds on it does without news"

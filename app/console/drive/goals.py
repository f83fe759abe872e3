"""Goals of the robot that came over the console, and what ends them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.attention.desires import Desire
from app.attention.workspace import IntentionWorkspace
from app.console import reports
from app.messages import NavigationReport

if TYPE_CHECKING:
    from app.program.system import System

#: The desire class that sends the robot somewhere.
GO_TO = "GoTo"
#: Those that drive it into a dock and out of it, and from one unknown place to the next. They end with any goal,
#: whatever desired them: a person who stops the robot means this, too.
SELF_DRIVEN = frozenset({"Dock", "Undock", "Explore"})
#: The channel that says where the robot goes.
REPORT = "navigation_report"
#: Goals of these sources came over the console.
_ASKED_HERE = frozenset({"operator", "rest"})
#: States of a tour on its way.
_ON_THE_WAY = frozenset({"leading", "waiting", "searching", "turning", "blocked", "lost", "going_home"})


def asked_here(workspace: IntentionWorkspace) -> list[Desire]:
    """Every goal that came over the console."""
    return [d for d in workspace.desires() if d.cls == GO_TO and d.source.kind in _ASKED_HERE]


def withdraw(workspace: IntentionWorkspace) -> None:
    """Remove every goal that came over the console, and every desire to dock or to explore."""
    with workspace.transaction():
        driven = [desire for desire in workspace.desires() if desire.cls in SELF_DRIVEN and desire.utility > 0]
        for desire in (*asked_here(workspace), *driven):
            workspace.remove(desire.id)


def withdraw_all(workspace: IntentionWorkspace) -> None:
    """Remove every goal and every desire to dock or to explore, of motivations and programs too; a desire that
    inhibits going anywhere stays."""
    with workspace.transaction():
        for desire in workspace.desires():
            if desire.cls in {GO_TO, *SELF_DRIVEN} and desire.utility > 0:
                workspace.remove(desire.id)


def pause_tour(system: System) -> None:
    """Pause a tour that is on its way: a person who stops the robot means this, too. It goes on by a press."""
    if system.tour_run.available and system.tour_run.server.progress.state in _ON_THE_WAY:
        system.tour_run.server.press("pause")


def dismiss_given_up(system: System) -> None:
    """The goal that was given up is void: it was read, or was a place on another map."""
    report: NavigationReport | None = reports.latest(system.graph, REPORT)
    if report is not None and report.given_up is not None:
        system.timeline.add("goal", GO_TO, "The goal that was given up is void", {"given_up": None})

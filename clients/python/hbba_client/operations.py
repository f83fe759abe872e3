"""The operations of REST.

Written by `make types` from the program's own description; change that, not this file.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Literal

from .records import (
    CameraClick,
    CameraPoint,
    ChannelList,
    CurrentMap,
    Desire,
    DesireChange,
    DesireClassList,
    DesireClassReport,
    DesireReport,
    Desires,
    EmotionState,
    EStop,
    EventList,
    FleetReport,
    Goal,
    GoalRequest,
    Health,
    IntentionReport,
    KeptMap,
    LanesPast,
    LinkChange,
    LinkReport,
    LoadRequest,
    LoginRequest,
    MapList,
    MemoryReport,
    ModuleList,
    ModuleReport,
    NewDesire,
    NewPlace,
    NewRecording,
    NewRehearsal,
    NewTourRun,
    NewWebhook,
    NewWebhookReport,
    PlaceChange,
    PlacedPercepts,
    PlaceList,
    PlaceReplacement,
    PlaceReport,
    PlaybackChange,
    PlaybackReport,
    PoseRequest,
    RecordingList,
    RehearsalReport,
    RenameRequest,
    ReplayReport,
    ResourceChange,
    ResourceList,
    ResourceReport,
    RobotReport,
    RouteReport,
    RouteRequest,
    RulesReport,
    RunReport,
    RunReportList,
    Saved,
    SaveRequest,
    SceneAddress,
    SceneClick,
    ScenePoint,
    Session,
    StrategyList,
    TourList,
    TourMedia,
    TourMediaList,
    TourPress,
    TourReport,
    TourRunReport,
    TourVerdict,
    ViewerList,
    VisitorKey,
    VisitorLink,
    VisitorPress,
    WebhookList,
    WebhookReport,
    WebhookTrial,
    WhatIf,
    Withdrawn,
    ZoneList,
    ZonesRequest,
)
from .request import Request


class Operations(ABC):
    """What the program can be asked for; each method says which role may."""

    @abstractmethod
    def ask(self, request: Request) -> Any:
        """The answer to ``request``. Raises Problem for a refusal."""

    def add_tour_media(
        self,
        body: bytes,
        *,
        name: str | None = None,
        media: Literal["image/gif", "image/jpeg", "image/png", "image/webp", "video/mp4", "video/webm"] = "image/gif",
    ) -> TourMedia:
        """Hand in a picture or a video.

        The file itself is the body. What it is, its content says: JPEG, PNG, WebP, GIF, MP4 or WebM, and whole.
        `file` of the answer is what a tour's `show` names it: made of `name`, with a number where another has it.

        Role: operator.
        """
        result: TourMedia = self.ask(
            Request("POST", "/tour-media", TourMedia, body=body, media=media, query={"name": name})
        )
        return result

    def ask_what_if(self, body: WhatIf) -> IntentionReport:
        """What would be chosen.

        The intention under other desires, costs and budgets, with its reasons. The robot goes on as it is. One is
        answered at a time; `stamp` is when it was asked.

        Role: operator.
        """
        result: IntentionReport = self.ask(Request("POST", "/intention/what-if", IntentionReport, body=body))
        return result

    def begin_map(self) -> CurrentMap:
        """Begin an empty map.

        Without a name, the robot at its origin. The one in use is lost if it was not saved, and a goal on it
        withdrawn. Needs no body.

        Role: supervisor.
        """
        result: CurrentMap = self.ask(Request("POST", "/map/begin", CurrentMap))
        return result

    def cancel_goal(self) -> None:
        """Cancel the goal.

        Withdraws every desire of class GoTo that came over the console, and every one to dock or to explore, also
        the robot's own; a goal that the robot gave up is no longer reported. A guided tour on its way is paused.
        May be repeated.

        Role: operator.
        """

        self.ask(Request("DELETE", "/goal", None))

    def cancel_rehearsal(self) -> None:
        """Cancel the rehearsal, or forget it.

        There is none afterwards; also where there was none.

        Role: operator.
        """

        self.ask(Request("DELETE", "/tour-rehearsal", None))

    def change_desire(self, desire_id: str, body: DesireChange) -> Desire:
        """Change a desire in place.

        Members left out stay. `params` replaces all parameters, and may name a `place` as for a new desire; `ttl`
        counts from now, null makes it stay.

        Role: operator.
        """
        result: Desire = self.ask(Request("PATCH", f"/desires/{Request.quoted(desire_id)}", Desire, body=body))
        return result

    def change_place(self, place_id: str, body: PlaceChange, *, if_match: str | None = None) -> PlaceReport:
        """Rename or move a place.

        Members left out stay, and its id does. A place that is moved by hand follows no poster from then on.

        Role: operator.
        """
        result: PlaceReport = self.ask(
            Request(
                "PATCH", f"/places/{Request.quoted(place_id)}", PlaceReport, body=body, headers={"If-Match": if_match}
            )
        )
        return result

    def change_playback(self, body: PlaybackChange) -> PlaybackReport:
        """Play, pause, seek, change the speed.

        Members left out stay. Answers once it is so: after a seek, when the scene there is shown. Of several
        seeks at once only the newest is gone to, and all are answered then. A position beyond an end is that end;
        to play from the end is to begin again.

        Role: operator.
        """
        result: PlaybackReport = self.ask(Request("PATCH", "/playback", PlaybackReport, body=body))
        return result

    def change_resource(self, name: str, body: ResourceChange) -> ResourceReport:
        """Change a budget.

        Attention selects again within the new budget at once; it lasts until changed again or the program ends.

        Role: operator.
        """
        result: ResourceReport = self.ask(
            Request("PATCH", f"/resources/{Request.quoted(name)}", ResourceReport, body=body)
        )
        return result

    def change_tour(self, tour_id: str, body: dict[str, Any], *, if_match: str | None = None) -> TourReport:
        """Change a tour.

        A JSON Merge Patch (RFC 7396): members left out stay, null gives a member its usual value, a list is
        replaced as a whole. An id does not change.

        Role: operator.
        """
        result: TourReport = self.ask(
            Request("PATCH", f"/tours/{Request.quoted(tour_id)}", TourReport, body=body, headers={"If-Match": if_match})
        )
        return result

    def check_visitor(self) -> None:
        """Check whether a visitor has entered.

        204 for one that may see the tour, an operator's browser among them.

        Role: any.
        """

        self.ask(Request("GET", "/visitor/session", None))

    def create_desire(self, body: NewDesire, *, idempotency_key: str | None = None) -> Desire:
        """Create a desire.

        Attention weighs it at once: the intention that follows is on the live stream and in `GET /intention`.

        A desire with a `ttl` expires by itself, so that a client that dies leaves nothing behind. Refused while
        there are 1000 desires from the console. `params` of GoTo may be a `place` of the map, by its id, instead
        of coordinates.

        Role: operator.
        """
        result: Desire = self.ask(
            Request("POST", "/desires", Desire, body=body, headers={"idempotency-key": idempotency_key})
        )
        return result

    def create_place(self, body: NewPlace) -> PlaceReport:
        """Create a place.

        By its coordinates (`pose`), where the robot is (`here`), or in front of a `poster`: 1.2 m from it along
        its normal, looking at it. It is kept with the map at once if that has a name. One where the robot cannot
        stand is taken, and says so in its `problem`.

        Role: operator.
        """
        result: PlaceReport = self.ask(Request("POST", "/places", PlaceReport, body=body))
        return result

    def create_tour(self, body: dict[str, Any]) -> TourReport:
        """Create a tour.

        Under the id in it. What it refers to need not exist yet: the `problems` say what it lacks to run.

        Role: operator.
        """
        result: TourReport = self.ask(Request("POST", "/tours", TourReport, body=body))
        return result

    def create_webhook(self, body: NewWebhook) -> NewWebhookReport:
        """Have events posted to a URL.

        From now on each event of these `kinds` is posted to `url`, in order, one at a time, signed as the
        specification Standard Webhooks 1.0 says, until the receiver answers 2xx: again after 1 s, 5 s, 30 s, 2
        min, and then every 10 min for a day. A receiver that answers 410 gets nothing more. `secret` is answered
        once.

        Role: supervisor.
        """
        result: NewWebhookReport = self.ask(Request("POST", "/webhooks", NewWebhookReport, body=body))
        return result

    def delete_episode(self, episode: int) -> None:
        """Delete an episode.

        With the events that were its own.

        Role: supervisor.
        """

        self.ask(Request("DELETE", f"/memory/episodes/{Request.quoted(episode)}", None))

    def delete_map(self, name: str) -> None:
        """Delete a map.

        For good, with its zones. The map in use is refused.

        Role: supervisor.
        """

        self.ask(Request("DELETE", f"/maps/{Request.quoted(name)}", None))

    def delete_memory(self) -> None:
        """Delete all that is remembered.

        Also what is under way. What is deleted is overwritten on the disk.

        Role: supervisor.
        """

        self.ask(Request("DELETE", "/memory", None))

    def delete_place(self, place_id: str, *, if_match: str | None = None) -> None:
        """Delete a place.

        Goals that were given by it stay: they are its pose.

        Role: operator.
        """

        self.ask(Request("DELETE", f"/places/{Request.quoted(place_id)}", None, headers={"If-Match": if_match}))

    def delete_recording(self, name: str) -> None:
        """Delete a recording.

        For good. One that is being written is refused: stop first; so is one that is being replayed, here or in a
        replay that was started here: end that first.

        Role: supervisor.
        """

        self.ask(Request("DELETE", f"/recordings/{Request.quoted(name)}", None))

    def delete_tour(self, tour_id: str, *, if_match: str | None = None) -> None:
        """Delete a tour.

        `POST /tours/{tour_id}/undo` brings it back until the program ends. Where it was a changed tour of the
        program's, that one is there again; the program's own are not deleted.

        Role: supervisor.
        """

        self.ask(Request("DELETE", f"/tours/{Request.quoted(tour_id)}", None, headers={"If-Match": if_match}))

    def delete_tour_media(self, file: str) -> None:
        """Delete a picture or a video.

        For good; `undo` of a tour does not bring it back. One that a tour shows is not deleted.

        Role: operator.
        """

        self.ask(Request("DELETE", f"/tour-media/{Request.quoted(file)}", None))

    def delete_tour_report(self, run_id: str) -> None:
        """Delete a report.

        Role: supervisor.
        """

        self.ask(Request("DELETE", f"/tour-reports/{Request.quoted(run_id)}", None))

    def delete_webhook(self, webhook_id: str) -> None:
        """Remove a webhook.

        Nothing more is posted; events that wait are given up.

        Role: supervisor.
        """

        self.ask(Request("DELETE", f"/webhooks/{Request.quoted(webhook_id)}", None))

    def dismiss_tour(self) -> None:
        """Wait for visitors no more.

        A tour that is under way is ended by its button `end` before.

        Role: operator.
        """

        self.ask(Request("DELETE", "/tour-run", None))

    def end_replay(self, name: str) -> None:
        """End a replay.

        Role: operator.
        """

        self.ask(Request("DELETE", f"/recordings/{Request.quoted(name)}/replay", None))

    def enter_as_visitor(self, body: VisitorKey) -> None:
        """Enter as a visitor.

        With the key of the link. Sets a cookie, which no script can read and which is sent below `/visitor`
        alone; it is over with the run.

        Role: any.
        """

        self.ask(Request("POST", "/visitor/session", None, body=body))

    def export_tour(self, tour_id: str) -> str:
        """Export a tour's file.

        Without pictures and videos.

        Role: spectator.
        """
        result: str = self.ask(Request("GET", f"/tours/{Request.quoted(tour_id)}/file", str))
        return result

    def export_tour_archive(self, tour_id: str) -> bytes:
        """Export a tour with its pictures and videos.

        A ZIP archive of the tour's file and what it shows, without what is missing.

        Role: spectator.
        """
        result: bytes = self.ask(Request("GET", f"/tours/{Request.quoted(tour_id)}/archive", bytes))
        return result

    def export_tour_reports(self, *, tour: str | None = None) -> str:
        """Export reports on tours as a table.

        A line for each stop; times are UTC.

        Role: spectator.
        """
        result: str = self.ask(Request("GET", "/tour-reports.csv", str, query={"tour": tour}))
        return result

    def find_camera_point(self, body: CameraClick) -> CameraPoint:
        """A point of the picture on the map.

        Where that is on the map, which the robot saw there when the picture was taken.

        Role: spectator.
        """
        result: CameraPoint = self.ask(Request("POST", "/camera/point", CameraPoint, body=body))
        return result

    def find_scene_point(self, body: SceneClick) -> ScenePoint:
        """What a point of a 3D view shows.

        The first thing on the ray of that view's camera, as it is drawn there: a poster, the map's walls, what
        the depth camera saw, or the floor; and where that is.

        Role: spectator.
        """
        result: ScenePoint = self.ask(Request("POST", "/scene/point", ScenePoint, body=body))
        return result

    def get_desire(self, desire_id: str, *, wait: float | None = None) -> DesireReport:
        """One desire, and what became of it.

        A desire that left is kept for ten minutes, of the last 2000. Where more than 24 requests wait, the one
        that has waited longest is answered at once.

        Role: spectator.
        """
        result: DesireReport = self.ask(
            Request("GET", f"/desires/{Request.quoted(desire_id)}", DesireReport, query={"wait": wait})
        )
        return result

    def get_desire_class(self, name: str) -> DesireClassReport:
        """One desire class.

        Role: spectator.
        """
        result: DesireClassReport = self.ask(
            Request("GET", f"/desire-classes/{Request.quoted(name)}", DesireClassReport)
        )
        return result

    def get_emotions(self) -> EmotionState:
        """What the robot feels, and why.

        Joy, anger, sadness and fear, each with the desire classes that it comes from, and the desires whose
        intensity is raised. A program without emotions feels nothing.

        Role: spectator.
        """
        result: EmotionState = self.ask(Request("GET", "/emotions", EmotionState))
        return result

    def get_fleet(self) -> FleetReport:
        """The robots of the fleet: state, and who drives.

        This robot, and those of the file of `hbba run --fleet`, whose consoles are asked now: one that does not
        answer within 2 s is `unreachable`.

        Role: spectator.
        """
        result: FleetReport = self.ask(Request("GET", "/fleet", FleetReport))
        return result

    def get_goal(self) -> Goal:
        """The goal and the state of navigation.

        What is desired, and what the behavior that goes there is about.

        Role: spectator.
        """
        result: Goal = self.ask(Request("GET", "/goal", Goal))
        return result

    def get_health(self) -> Health:
        """Health of the program.

        Open to all; `degraded` while a module does not run, the body is silent, or a recording has ended by
        itself, until that is stopped (`POST /recordings/stop`) or another begins.

        Role: any.
        """
        result: Health = self.ask(Request("GET", "/health", Health))
        return result

    def get_intention(self) -> IntentionReport:
        """The intention and its reasons.

        The strategies at work, the filters they set, Ω, what they use of each resource, and for each desired
        class the reason why it gets what it gets.

        Role: spectator.
        """
        result: IntentionReport = self.ask(Request("GET", "/intention", IntentionReport))
        return result

    def get_lanes(self, *, from_: float | None = None, to: float | None = None, points: int | None = None) -> LanesPast:
        """What the lanes were.

        The last hour is kept, twice a second, and of a recording what was played. Where that is more than
        `points` it is put into buckets of equal width; a closing shorter than a bucket stays among the `changes`.

        Role: spectator.
        """
        result: LanesPast = self.ask(
            Request("GET", "/lanes", LanesPast, query={"from": from_, "to": to, "points": points})
        )
        return result

    def get_link(self) -> LinkReport:
        """How the link to the pages is shaped, for tests.

        Role: spectator.
        """
        result: LinkReport = self.ask(Request("GET", "/link", LinkReport))
        return result

    def get_map(self) -> CurrentMap:
        """The map in use.

        Role: spectator.
        """
        result: CurrentMap = self.ask(Request("GET", "/map", CurrentMap))
        return result

    def get_map_picture(self, name: str) -> bytes:
        """A map's picture.

        One pixel a cell; its top row has the greatest y.

        Role: spectator.
        """
        result: bytes = self.ask(Request("GET", f"/maps/{Request.quoted(name)}/picture", bytes))
        return result

    def get_memory(self) -> MemoryReport:
        """Export what is remembered.

        All episodes, those that happened last first, and their events. Of people, it has numbers alone. Refused
        where memory is off.

        Role: spectator.
        """
        result: MemoryReport = self.ask(Request("GET", "/memory", MemoryReport))
        return result

    def get_module(self, name: str) -> ModuleReport:
        """One module.

        Role: spectator.
        """
        result: ModuleReport = self.ask(Request("GET", f"/modules/{Request.quoted(name)}", ModuleReport))
        return result

    def get_percepts(self) -> PlacedPercepts:
        """Faces, sounds, loud noises, codes.

        The same as `perceived` on the live stream. What attention has closed is not perceived.

        Role: spectator.
        """
        result: PlacedPercepts = self.ask(Request("GET", "/percepts", PlacedPercepts))
        return result

    def get_place(self, place_id: str) -> PlaceReport:
        """One place.

        Role: spectator.
        """
        result: PlaceReport = self.ask(Request("GET", f"/places/{Request.quoted(place_id)}", PlaceReport))
        return result

    def get_playback(self) -> PlaybackReport:
        """State of the playback.

        Role: spectator.
        """
        result: PlaybackReport = self.ask(Request("GET", "/playback", PlaybackReport))
        return result

    def get_rehearsal(self) -> RehearsalReport:
        """The rehearsal under way, or the last.

        How far it is; once it is `done`, what was said and done when, where the robot was, and what went wrong.

        Role: spectator.
        """
        result: RehearsalReport = self.ask(Request("GET", "/tour-rehearsal", RehearsalReport))
        return result

    def get_robot(self) -> RobotReport:
        """State of the robot: pose, guard, driver.

        Role: spectator.
        """
        result: RobotReport = self.ask(Request("GET", "/robot", RobotReport))
        return result

    def get_scene(self) -> SceneAddress:
        """Where the 3D view for a page's frame is.

        Its address on the port of the 3D view, for a client that reached the console under this request's `Host`.
        Where that names another port than the console's own, as behind a proxy, the second port's address is not
        known, and the view is at `/viser/` here.

        Role: spectator.
        """
        result: SceneAddress = self.ask(Request("GET", "/scene", SceneAddress))
        return result

    def get_session(self) -> Session:
        """Check the login.

        200 if this client may use the console; 401 where it must log in.

        Role: any.
        """
        result: Session = self.ask(Request("GET", "/session", Session))
        return result

    def get_timeline(
        self,
        *,
        since: float | None = None,
        until: float | None = None,
        kinds: str | None = None,
        after_id: int | None = None,
        limit: int | None = None,
    ) -> EventList:
        """Events of the timeline.

        Oldest first. To follow it, ask again with `after_id` of the last one had.

        Role: spectator.
        """
        result: EventList = self.ask(
            Request(
                "GET",
                "/timeline",
                EventList,
                query={"since": since, "until": until, "kinds": kinds, "after_id": after_id, "limit": limit},
            )
        )
        return result

    def get_tour(self, tour_id: str) -> TourReport:
        """One tour.

        Role: spectator.
        """
        result: TourReport = self.ask(Request("GET", f"/tours/{Request.quoted(tour_id)}", TourReport))
        return result

    def get_tour_media(self, file: str) -> bytes:
        """A picture or a video.

        Whole, or in part (`Range`).

        Role: spectator.
        """
        result: bytes = self.ask(Request("GET", f"/tour-media/{Request.quoted(file)}", bytes))
        return result

    def get_tour_posters(
        self,
        tour_id: str,
        *,
        paper: Literal["a4", "letter"] | None = None,
        language: str | None = None,
        stop: str | None = None,
    ) -> bytes:
        """Print posters.

        Of the stops that have the text of a `poster`.

        Role: spectator.
        """
        result: bytes = self.ask(
            Request(
                "GET",
                f"/tours/{Request.quoted(tour_id)}/posters.pdf",
                bytes,
                query={"paper": paper, "language": language, "stop": stop},
            )
        )
        return result

    def get_tour_report(self, run_id: str) -> RunReport:
        """One report on a tour.

        Role: spectator.
        """
        result: RunReport = self.ask(Request("GET", f"/tour-reports/{Request.quoted(run_id)}", RunReport))
        return result

    def get_tour_run(self) -> TourRunReport:
        """The tour under way.

        How it goes, and what the run has been so far; of the last one after its end.

        Role: spectator.
        """
        result: TourRunReport = self.ask(Request("GET", "/tour-run", TourRunReport))
        return result

    def get_tour_schema(self) -> Any:
        """The JSON Schema of a tour.

        Draft 2020-12. What it cannot say, `POST /tours/validate` finds.

        Role: spectator.
        """
        result: Any = self.ask(Request("GET", "/tour-schema", Any))
        return result

    def get_visitor_link(self) -> VisitorLink:
        """The link for visitors' phones.

        For operators: the page for visitors with the key of this run, and its QR code. The key changes with each
        run, and opens nothing but that page.

        Role: operator.
        """
        result: VisitorLink = self.ask(Request("GET", "/tour-run/visitors", VisitorLink))
        return result

    def get_visitor_media(self, file: str) -> bytes:
        """A picture or a video of the tour.

        Only what the tour under way names, out of the folder of tours; also in part (`Range`).

        Role: spectator.
        """
        result: bytes = self.ask(Request("GET", f"/visitor/media/{Request.quoted(file)}", bytes))
        return result

    def get_webhook(self, webhook_id: str) -> WebhookReport:
        """One webhook.

        Role: supervisor.
        """
        result: WebhookReport = self.ask(Request("GET", f"/webhooks/{Request.quoted(webhook_id)}", WebhookReport))
        return result

    def get_zones(self) -> ZoneList:
        """Zones of the map in use.

        Role: spectator.
        """
        result: ZoneList = self.ask(Request("GET", "/map/zones", ZoneList))
        return result

    def import_tour(
        self,
        body: str | bytes,
        *,
        if_match: str | None = None,
        media: Literal["application/yaml", "application/zip"] = "application/yaml",
    ) -> TourReport:
        """Import a tour's file.

        YAML, as `GET /tours/{tour_id}/file` gives it (or JSON, which is YAML), or the archive of `GET
        /tours/{tour_id}/archive`, under the id in it. With `If-Match` it replaces the tour of this id (200);
        without, that is refused. The media of an archive are kept with the tour or not at all; where another
        picture has a name, the tour names the new one.

        Role: operator.
        """
        result: TourReport = self.ask(
            Request("POST", "/tours/import", TourReport, body=body, media=media, headers={"If-Match": if_match})
        )
        return result

    def latch_e_stop(self) -> EStop:
        """Latch the emergency stop.

        Latches the emergency stop in the guard: the wheels are commanded to zero until it is released here or on
        the page. Answers once the guard has confirmed it. Needs no body. May be repeated.

        Role: spectator.
        """
        result: EStop = self.ask(Request("POST", "/stop", EStop))
        return result

    def list_channels(self) -> ChannelList:
        """Channels, their freshness and counters.

        Role: spectator.
        """
        result: ChannelList = self.ask(Request("GET", "/channels", ChannelList))
        return result

    def list_desire_classes(self) -> DesireClassList:
        """List all desire classes.

        Each class with the JSON Schema of its parameters: enough to build a form from.

        Role: spectator.
        """
        result: DesireClassList = self.ask(Request("GET", "/desire-classes", DesireClassList))
        return result

    def list_desires(self) -> Desires:
        """List all desires.

        With what has become of each so far: intended, exploited, and since when (`progress`).

        Role: spectator.
        """
        result: Desires = self.ask(Request("GET", "/desires", Desires))
        return result

    def list_maps(self) -> MapList:
        """List all maps.

        By name; and the one in use, which may have no name yet.

        Role: spectator.
        """
        result: MapList = self.ask(Request("GET", "/maps", MapList))
        return result

    def list_modules(self) -> ModuleList:
        """Modules, their load and counters.

        Role: spectator.
        """
        result: ModuleList = self.ask(Request("GET", "/modules", ModuleList))
        return result

    def list_places(self) -> PlaceList:
        """List all places of the map in use.

        In the order of their making; each with its `etag`.

        Role: spectator.
        """
        result: PlaceList = self.ask(Request("GET", "/places", PlaceList))
        return result

    def list_recordings(self) -> RecordingList:
        """List all recordings.

        The newest first, with the room left on the disk and what the Recorder does.

        Role: spectator.
        """
        result: RecordingList = self.ask(Request("GET", "/recordings", RecordingList))
        return result

    def list_resources(self) -> ResourceList:
        """Resources: budgets and use.

        Role: spectator.
        """
        result: ResourceList = self.ask(Request("GET", "/resources", ResourceList))
        return result

    def list_rules(self) -> RulesReport:
        """Rules, and when each applied last.

        The rules by which something is desired without code, in force now. Where a file was changed and has a
        mistake, `problem` says which, and the rules are still those before. No rules: the program has none.

        Role: spectator.
        """
        result: RulesReport = self.ask(Request("GET", "/rules", RulesReport))
        return result

    def list_strategies(self) -> StrategyList:
        """List all strategies.

        Role: spectator.
        """
        result: StrategyList = self.ask(Request("GET", "/strategies", StrategyList))
        return result

    def list_tour_media(self) -> TourMediaList:
        """List pictures and videos of tours.

        All that tours can show, by name, with the tours that do.

        Role: spectator.
        """
        result: TourMediaList = self.ask(Request("GET", "/tour-media", TourMediaList))
        return result

    def list_tour_reports(self, *, tour: str | None = None) -> RunReportList:
        """List reports on tours.

        The newest first. Of people, they have counts alone.

        Role: spectator.
        """
        result: RunReportList = self.ask(Request("GET", "/tour-reports", RunReportList, query={"tour": tour}))
        return result

    def list_tours(self) -> TourList:
        """List all tours.

        By id, those that come with the program among them; each with its `etag`.

        Role: spectator.
        """
        result: TourList = self.ask(Request("GET", "/tours", TourList))
        return result

    def list_viewers(self) -> ViewerList:
        """Connected pages and 3D views, and their connections.

        Role: spectator.
        """
        result: ViewerList = self.ask(Request("GET", "/viewers", ViewerList))
        return result

    def list_webhooks(self) -> WebhookList:
        """List all webhooks.

        In the order of their making, with how their deliveries go; without their secrets.

        Role: supervisor.
        """
        result: WebhookList = self.ask(Request("GET", "/webhooks", WebhookList))
        return result

    def load_map(self, name: str, body: LoadRequest | None = None) -> CurrentMap:
        """Take a map into use.

        In place of the one in use, which is lost if it was not saved. Needs no body: the robot then looks for
        itself on the map, and the map stays as it is. Every goal is withdrawn: it was a place on the other map.

        Role: supervisor.
        """
        result: CurrentMap = self.ask(Request("POST", f"/maps/{Request.quoted(name)}/load", CurrentMap, body=body))
        return result

    def log_in(self, body: LoginRequest) -> Session:
        """Log in.

        Begins a session and sets its cookie, which no script can read and no other site can use, until the
        browser is closed. The session is over when nothing was asked in it for 12 hours, at the logout, or with
        the console. It has the role of the password; with the token it is a supervisor's. After five wrong tokens
        an address waits, longer with each further one.

        Role: any.
        """
        result: Session = self.ask(Request("POST", "/session", Session, body=body))
        return result

    def log_out(self) -> None:
        """Log out.

        Ends this browser's session, and its WebSockets.

        Role: any.
        """

        self.ask(Request("DELETE", "/session", None))

    def place_robot(self, body: PoseRequest) -> CurrentMap:
        """Set the robot's pose on the map.

        On the map in use, within 1 m and 0.5 rad; from there its pose is refined by what the laser sees.

        Role: operator.
        """
        result: CurrentMap = self.ask(Request("PUT", "/map/pose", CurrentMap, body=body))
        return result

    def plan_route(self, body: RouteRequest) -> RouteReport:
        """Plan a route.

        Leg by leg, by the robot's own planner, on the map in use, its zones and what it keeps in mind of
        obstacles; what is there for the moment does not count. Nothing moves. A leg that cannot be driven says
        why.

        Role: spectator.
        """
        result: RouteReport = self.ask(Request("POST", "/map/route", RouteReport, body=body))
        return result

    def press_as_visitor(self, body: VisitorPress) -> None:
        """Press as a visitor.

        A `button` that the tour waits for, or a question that may be asked now.

        Role: operator.
        """

        self.ask(Request("POST", "/visitor/press", None, body=body))

    def press_tour(self, body: TourPress) -> TourRunReport:
        """Steer the tour under way.

        A `button` (`pause`, `resume`, `skip`, `undo_skip`, `repeat`, `retry`, `end`, and the visitors' `agree`,
        `decline`, `next`), a `stop` to go to, or a question that a visitor asks. What does nothing now is
        refused; the answer's `buttons` are those that do.

        Role: operator.
        """
        result: TourRunReport = self.ask(Request("POST", "/tour-run/press", TourRunReport, body=body))
        return result

    def put_link(self, body: LinkChange) -> LinkReport:
        """Shape the link to the pages, for tests.

        Delays and bounds every stream between the program and its pages from now on, this answer included: live
        stream, 3D view, REST. `{}` ends it. Streams are ordered, so nothing is lost: a lost packet is sent again,
        and what follows it waits.

        Role: supervisor.
        """
        result: LinkReport = self.ask(Request("PUT", "/link", LinkReport, body=body))
        return result

    def redo_tour(self, tour_id: str, *, if_match: str | None = None) -> TourReport | None:
        """Do again what was undone last.

        Needs no body.

        Role: operator.
        """
        result: TourReport | None = self.ask(
            Request("POST", f"/tours/{Request.quoted(tour_id)}/redo", TourReport | None, headers={"If-Match": if_match})
        )
        return result

    def release_e_stop(self, *, seen: float | None = None) -> EStop:
        """Release the emergency stop.

        A stop that was pressed after `seen` stays latched, so that a late release does not undo a stop that its
        sender has not seen. The base stays still until the next fresh command. Answers once the guard has
        confirmed it, or half a second later: a goal that is given next is not refused for a latch that is gone.
        An operator releases what no other pressed, a supervisor any stop.

        Role: operator.
        """
        result: EStop = self.ask(Request("DELETE", "/stop", EStop, query={"seen": seen}))
        return result

    def remove_desire(self, desire_id: str) -> None:
        """Remove a desire.

        Role: operator.
        """

        self.ask(Request("DELETE", f"/desires/{Request.quoted(desire_id)}", None))

    def rename_map(self, name: str, body: RenameRequest) -> KeptMap:
        """Rename a map.

        A name that another map has is refused. The map in use is saved under its new name as it is now.

        Role: supervisor.
        """
        result: KeptMap = self.ask(Request("PATCH", f"/maps/{Request.quoted(name)}", KeptMap, body=body))
        return result

    def replace_place(self, place_id: str, body: PlaceReplacement, *, if_match: str | None = None) -> PlaceReport:
        """Replace a place, or create it under this id.

        Without a name it keeps the one that it has. With `If-Match`, nothing is created.

        Role: operator.
        """
        result: PlaceReport = self.ask(
            Request(
                "PUT", f"/places/{Request.quoted(place_id)}", PlaceReport, body=body, headers={"If-Match": if_match}
            )
        )
        return result

    def replace_tour(self, tour_id: str, body: dict[str, Any], *, if_match: str | None = None) -> TourReport:
        """Replace a tour, or create it under this id.

        The id in it may be left out. With `If-Match`, nothing is created.

        Role: operator.
        """
        result: TourReport = self.ask(
            Request("PUT", f"/tours/{Request.quoted(tour_id)}", TourReport, body=body, headers={"If-Match": if_match})
        )
        return result

    def replay_recording(self, name: str) -> ReplayReport:
        """Replay a recording.

        Starts `hbba replay` with a console of its own and answers once that is up, within seconds. A replay
        started here before is ended. It ends with this console, and by itself three minutes after its last viewer
        left.

        Role: operator.
        """
        result: ReplayReport = self.ask(Request("POST", f"/recordings/{Request.quoted(name)}/replay", ReplayReport))
        return result

    def save_map(self, name: str) -> KeptMap:
        """Keep the map in use.

        Under this name, which it has from then on; an older map of this name is replaced. Needs no body.

        Role: supervisor.
        """
        result: KeptMap = self.ask(Request("PUT", f"/maps/{Request.quoted(name)}", KeptMap))
        return result

    def save_ring(self, body: SaveRequest | None = None) -> Saved:
        """Keep the ring's last minutes.

        Makes a recording of what the ring holds; the ring goes on. Needs no body.

        Role: operator.
        """
        result: Saved = self.ask(Request("POST", "/recordings/save", Saved, body=body))
        return result

    def search_robot(self) -> CurrentMap:
        """Start global localization.

        It is somewhere on the map in use, and finds out where. Needs no body.

        Role: operator.
        """
        result: CurrentMap = self.ask(Request("POST", "/map/search", CurrentMap))
        return result

    def set_goal(self, body: GoalRequest) -> Desire:
        """Send the robot somewhere.

        Creates a desire of class GoTo, or changes the one that was created so before: there is one goal of people
        at a time, and a second takes the first one's place. Attention weighs it as any other; how the robot does
        is in `navigation` of GET /goal and of the live stream. The same goal again changes nothing. A goal by
        `place` is the pose that the place has now; one in an obstacle of the map or in a keep-out zone is
        refused.

        Role: operator.
        """
        result: Desire = self.ask(Request("PUT", "/goal", Desire, body=body))
        return result

    def set_zones(self, body: ZonesRequest) -> ZoneList:
        """Draw the zones of the map in use.

        All of them: what is not named is gone. They are kept with the map at once if it has a name.

        Role: operator.
        """
        result: ZoneList = self.ask(Request("PUT", "/map/zones", ZoneList, body=body))
        return result

    def start_recording(self, body: NewRecording | None = None, *, idempotency_key: str | None = None) -> Desire:
        """Start recording.

        Creates a desire of class Record; attention weighs it as any other. Whether it records, and if not why, is
        in `recorder` of the list and on the live stream. Needs no body.

        Refused while a recording runs that was asked for here; a ring gives way, and what it held is kept as a
        recording of its own.

        Role: operator.
        """
        result: Desire = self.ask(
            Request("POST", "/recordings", Desire, body=body, headers={"idempotency-key": idempotency_key})
        )
        return result

    def start_rehearsal(self, tour_id: str, body: NewRehearsal) -> RehearsalReport:
        """Rehearse a tour.

        Plays the tour as it is kept on its map, without the robot, in a process of its own: the robot may be
        driven meanwhile. Follow it by `GET /tour-rehearsal`.

        Role: operator.
        """
        result: RehearsalReport = self.ask(
            Request("POST", f"/tours/{Request.quoted(tour_id)}/rehearsal", RehearsalReport, body=body)
        )
        return result

    def start_tour(self, tour_id: str, body: NewTourRun) -> TourRunReport:
        """Begin a tour.

        Now, or when visitors come. Refused while another is under way, while the robot is held, and where the
        tour lacks something that it needs (`errors` of its `problems`).

        Role: operator.
        """
        result: TourRunReport = self.ask(
            Request("POST", f"/tours/{Request.quoted(tour_id)}/run", TourRunReport, body=body)
        )
        return result

    def step_playback(self) -> PlaybackReport:
        """Step to the next image.

        To the next image of the first camera; in a recording without images to the next scan, without scans by
        0.1 s. Answers once the modules have done with it.

        Role: operator.
        """
        result: PlaybackReport = self.ask(Request("POST", "/playback/step", PlaybackReport))
        return result

    def stop_recording(self) -> Withdrawn:
        """Stop recording.

        Withdraws every desire of class Record that came over the console. Needs no body. May be repeated.

        Role: operator.
        """
        result: Withdrawn = self.ask(Request("POST", "/recordings/stop", Withdrawn))
        return result

    def try_webhook(self, webhook_id: str) -> WebhookTrial:
        """Post an event for a trial.

        Posts one event, whose `data.data.trial` is true, once, and answers with what became of it.

        Role: supervisor.
        """
        result: WebhookTrial = self.ask(Request("POST", f"/webhooks/{Request.quoted(webhook_id)}/trial", WebhookTrial))
        return result

    def undo_tour(
        self, tour_id: str, *, to_begin: bool | None = None, if_match: str | None = None
    ) -> TourReport | None:
        """Undo the newest change of a tour.

        Anyone's, since the program began: edits, deletion, import, and what a text editor changed in the file.
        Needs no body.

        Role: operator.
        """
        result: TourReport | None = self.ask(
            Request(
                "POST",
                f"/tours/{Request.quoted(tour_id)}/undo",
                TourReport | None,
                query={"to_begin": to_begin},
                headers={"If-Match": if_match},
            )
        )
        return result

    def validate_tour(self, body: dict[str, Any]) -> TourVerdict:
        """Check a tour.

        Without keeping it. Every mistake is found, with what else it lacks to run on this robot.

        Role: spectator.
        """
        result: TourVerdict = self.ask(Request("POST", "/tours/validate", TourVerdict, body=body))
        return result


class AsyncOperations(ABC):
    """What the program can be asked for; each method says which role may."""

    @abstractmethod
    async def ask(self, request: Request) -> Any:
        """The answer to ``request``. Raises Problem for a refusal."""

    async def add_tour_media(
        self,
        body: bytes,
        *,
        name: str | None = None,
        media: Literal["image/gif", "image/jpeg", "image/png", "image/webp", "video/mp4", "video/webm"] = "image/gif",
    ) -> TourMedia:
        """Hand in a picture or a video.

        The file itself is the body. What it is, its content says: JPEG, PNG, WebP, GIF, MP4 or WebM, and whole.
        `file` of the answer is what a tour's `show` names it: made of `name`, with a number where another has it.

        Role: operator.
        """
        result: TourMedia = await self.ask(
            Request("POST", "/tour-media", TourMedia, body=body, media=media, query={"name": name})
        )
        return result

    async def ask_what_if(self, body: WhatIf) -> IntentionReport:
        """What would be chosen.

        The intention under other desires, costs and budgets, with its reasons. The robot goes on as it is. One is
        answered at a time; `stamp` is when it was asked.

        Role: operator.
        """
        result: IntentionReport = await self.ask(Request("POST", "/intention/what-if", IntentionReport, body=body))
        return result

    async def begin_map(self) -> CurrentMap:
        """Begin an empty map.

        Without a name, the robot at its origin. The one in use is lost if it was not saved, and a goal on it
        withdrawn. Needs no body.

        Role: supervisor.
        """
        result: CurrentMap = await self.ask(Request("POST", "/map/begin", CurrentMap))
        return result

    async def cancel_goal(self) -> None:
        """Cancel the goal.

        Withdraws every desire of class GoTo that came over the console, and every one to dock or to explore, also
        the robot's own; a goal that the robot gave up is no longer reported. A guided tour on its way is paused.
        May be repeated.

        Role: operator.
        """

        await self.ask(Request("DELETE", "/goal", None))

    async def cancel_rehearsal(self) -> None:
        """Cancel the rehearsal, or forget it.

        There is none afterwards; also where there was none.

        Role: operator.
        """

        await self.ask(Request("DELETE", "/tour-rehearsal", None))

    async def change_desire(self, desire_id: str, body: DesireChange) -> Desire:
        """Change a desire in place.

        Members left out stay. `params` replaces all parameters, and may name a `place` as for a new desire; `ttl`
        counts from now, null makes it stay.

        Role: operator.
        """
        result: Desire = await self.ask(Request("PATCH", f"/desires/{Request.quoted(desire_id)}", Desire, body=body))
        return result

    async def change_place(self, place_id: str, body: PlaceChange, *, if_match: str | None = None) -> PlaceReport:
        """Rename or move a place.

        Members left out stay, and its id does. A place that is moved by hand follows no poster from then on.

        Role: operator.
        """
        result: PlaceReport = await self.ask(
            Request(
                "PATCH", f"/places/{Request.quoted(place_id)}", PlaceReport, body=body, headers={"If-Match": if_match}
            )
        )
        return result

    async def change_playback(self, body: PlaybackChange) -> PlaybackReport:
        """Play, pause, seek, change the speed.

        Members left out stay. Answers once it is so: after a seek, when the scene there is shown. Of several
        seeks at once only the newest is gone to, and all are answered then. A position beyond an end is that end;
        to play from the end is to begin again.

        Role: operator.
        """
        result: PlaybackReport = await self.ask(Request("PATCH", "/playback", PlaybackReport, body=body))
        return result

    async def change_resource(self, name: str, body: ResourceChange) -> ResourceReport:
        """Change a budget.

        Attention selects again within the new budget at once; it lasts until changed again or the program ends.

        Role: operator.
        """
        result: ResourceReport = await self.ask(
            Request("PATCH", f"/resources/{Request.quoted(name)}", ResourceReport, body=body)
        )
        return result

    async def change_tour(self, tour_id: str, body: dict[str, Any], *, if_match: str | None = None) -> TourReport:
        """Change a tour.

        A JSON Merge Patch (RFC 7396): members left out stay, null gives a member its usual value, a list is
        replaced as a whole. An id does not change.

        Role: operator.
        """
        result: TourReport = await self.ask(
            Request("PATCH", f"/tours/{Request.quoted(tour_id)}", TourReport, body=body, headers={"If-Match": if_match})
        )
        return result

    async def check_visitor(self) -> None:
        """Check whether a visitor has entered.

        204 for one that may see the tour, an operator's browser among them.

        Role: any.
        """

        await self.ask(Request("GET", "/visitor/session", None))

    async def create_desire(self, body: NewDesire, *, idempotency_key: str | None = None) -> Desire:
        """Create a desire.

        Attention weighs it at once: the intention that follows is on the live stream and in `GET /intention`.

        A desire with a `ttl` expires by itself, so that a client that dies leaves nothing behind. Refused while
        there are 1000 desires from the console. `params` of GoTo may be a `place` of the map, by its id, instead
        of coordinates.

        Role: operator.
        """
        result: Desire = await self.ask(
            Request("POST", "/desires", Desire, body=body, headers={"idempotency-key": idempotency_key})
        )
        return result

    async def create_place(self, body: NewPlace) -> PlaceReport:
        """Create a place.

        By its coordinates (`pose`), where the robot is (`here`), or in front of a `poster`: 1.2 m from it along
        its normal, looking at it. It is kept with the map at once if that has a name. One where the robot cannot
        stand is taken, and says so in its `problem`.

        Role: operator.
        """
        result: PlaceReport = await self.ask(Request("POST", "/places", PlaceReport, body=body))
        return result

    async def create_tour(self, body: dict[str, Any]) -> TourReport:
        """Create a tour.

        Under the id in it. What it refers to need not exist yet: the `problems` say what it lacks to run.

        Role: operator.
        """
        result: TourReport = await self.ask(Request("POST", "/tours", TourReport, body=body))
        return result

    async def create_webhook(self, body: NewWebhook) -> NewWebhookReport:
        """Have events posted to a URL.

        From now on each event of these `kinds` is posted to `url`, in order, one at a time, signed as the
        specification Standard Webhooks 1.0 says, until the receiver answers 2xx: again after 1 s, 5 s, 30 s, 2
        min, and then every 10 min for a day. A receiver that answers 410 gets nothing more. `secret` is answered
        once.

        Role: supervisor.
        """
        result: NewWebhookReport = await self.ask(Request("POST", "/webhooks", NewWebhookReport, body=body))
        return result

    async def delete_episode(self, episode: int) -> None:
        """Delete an episode.

        With the events that were its own.

        Role: supervisor.
        """

        await self.ask(Request("DELETE", f"/memory/episodes/{Request.quoted(episode)}", None))

    async def delete_map(self, name: str) -> None:
        """Delete a map.

        For good, with its zones. The map in use is refused.

        Role: supervisor.
        """

        await self.ask(Request("DELETE", f"/maps/{Request.quoted(name)}", None))

    async def delete_memory(self) -> None:
        """Delete all that is remembered.

        Also what is under way. What is deleted is overwritten on the disk.

        Role: supervisor.
        """

        await self.ask(Request("DELETE", "/memory", None))

    async def delete_place(self, place_id: str, *, if_match: str | None = None) -> None:
        """Delete a place.

        Goals that were given by it stay: they are its pose.

        Role: operator.
        """

        await self.ask(Request("DELETE", f"/places/{Request.quoted(place_id)}", None, headers={"If-Match": if_match}))

    async def delete_recording(self, name: str) -> None:
        """Delete a recording.

        For good. One that is being written is refused: stop first; so is one that is being replayed, here or in a
        replay that was started here: end that first.

        Role: supervisor.
        """

        await self.ask(Request("DELETE", f"/recordings/{Request.quoted(name)}", None))

    async def delete_tour(self, tour_id: str, *, if_match: str | None = None) -> None:
        """Delete a tour.

        `POST /tours/{tour_id}/undo` brings it back until the program ends. Where it was a changed tour of the
        program's, that one is there again; the program's own are not deleted.

        Role: supervisor.
        """

        await self.ask(Request("DELETE", f"/tours/{Request.quoted(tour_id)}", None, headers={"If-Match": if_match}))

    async def delete_tour_media(self, file: str) -> None:
        """Delete a picture or a video.

        For good; `undo` of a tour does not bring it back. One that a tour shows is not deleted.

        Role: operator.
        """

        await self.ask(Request("DELETE", f"/tour-media/{Request.quoted(file)}", None))

    async def delete_tour_report(self, run_id: str) -> None:
        """Delete a report.

        Role: supervisor.
        """

        await self.ask(Request("DELETE", f"/tour-reports/{Request.quoted(run_id)}", None))

    async def delete_webhook(self, webhook_id: str) -> None:
        """Remove a webhook.

        Nothing more is posted; events that wait are given up.

        Role: supervisor.
        """

        await self.ask(Request("DELETE", f"/webhooks/{Request.quoted(webhook_id)}", None))

    async def dismiss_tour(self) -> None:
        """Wait for visitors no more.

        A tour that is under way is ended by its button `end` before.

        Role: operator.
        """

        await self.ask(Request("DELETE", "/tour-run", None))

    async def end_replay(self, name: str) -> None:
        """End a replay.

        Role: operator.
        """

        await self.ask(Request("DELETE", f"/recordings/{Request.quoted(name)}/replay", None))

    async def enter_as_visitor(self, body: VisitorKey) -> None:
        """Enter as a visitor.

        With the key of the link. Sets a cookie, which no script can read and which is sent below `/visitor`
        alone; it is over with the run.

        Role: any.
        """

        await self.ask(Request("POST", "/visitor/session", None, body=body))

    async def export_tour(self, tour_id: str) -> str:
        """Export a tour's file.

        Without pictures and videos.

        Role: spectator.
        """
        result: str = await self.ask(Request("GET", f"/tours/{Request.quoted(tour_id)}/file", str))
        return result

    async def export_tour_archive(self, tour_id: str) -> bytes:
        """Export a tour with its pictures and videos.

        A ZIP archive of the tour's file and what it shows, without what is missing.

        Role: spectator.
        """
        result: bytes = await self.ask(Request("GET", f"/tours/{Request.quoted(tour_id)}/archive", bytes))
        return result

    async def export_tour_reports(self, *, tour: str | None = None) -> str:
        """Export reports on tours as a table.

        A line for each stop; times are UTC.

        Role: spectator.
        """
        result: str = await self.ask(Request("GET", "/tour-reports.csv", str, query={"tour": tour}))
        return result

    async def find_camera_point(self, body: CameraClick) -> CameraPoint:
        """A point of the picture on the map.

        Where that is on the map, which the robot saw there when the picture was taken.

        Role: spectator.
        """
        result: CameraPoint = await self.ask(Request("POST", "/camera/point", CameraPoint, body=body))
        return result

    async def find_scene_point(self, body: SceneClick) -> ScenePoint:
        """What a point of a 3D view shows.

        The first thing on the ray of that view's camera, as it is drawn there: a poster, the map's walls, what
        the depth camera saw, or the floor; and where that is.

        Role: spectator.
        """
        result: ScenePoint = await self.ask(Request("POST", "/scene/point", ScenePoint, body=body))
        return result

    async def get_desire(self, desire_id: str, *, wait: float | None = None) -> DesireReport:
        """One desire, and what became of it.

        A desire that left is kept for ten minutes, of the last 2000. Where more than 24 requests wait, the one
        that has waited longest is answered at once.

        Role: spectator.
        """
        result: DesireReport = await self.ask(
            Request("GET", f"/desires/{Request.quoted(desire_id)}", DesireReport, query={"wait": wait})
        )
        return result

    async def get_desire_class(self, name: str) -> DesireClassReport:
        """One desire class.

        Role: spectator.
        """
        result: DesireClassReport = await self.ask(
            Request("GET", f"/desire-classes/{Request.quoted(name)}", DesireClassReport)
        )
        return result

    async def get_emotions(self) -> EmotionState:
        """What the robot feels, and why.

        Joy, anger, sadness and fear, each with the desire classes that it comes from, and the desires whose
        intensity is raised. A program without emotions feels nothing.

        Role: spectator.
        """
        result: EmotionState = await self.ask(Request("GET", "/emotions", EmotionState))
        return result

    async def get_fleet(self) -> FleetReport:
        """The robots of the fleet: state, and who drives.

        This robot, and those of the file of `hbba run --fleet`, whose consoles are asked now: one that does not
        answer within 2 s is `unreachable`.

        Role: spectator.
        """
        result: FleetReport = await self.ask(Request("GET", "/fleet", FleetReport))
        return result

    async def get_goal(self) -> Goal:
        """The goal and the state of navigation.

        What is desired, and what the behavior that goes there is about.

        Role: spectator.
        """
        result: Goal = await self.ask(Request("GET", "/goal", Goal))
        return result

    async def get_health(self) -> Health:
        """Health of the program.

        Open to all; `degraded` while a module does not run, the body is silent, or a recording has ended by
        itself, until that is stopped (`POST /recordings/stop`) or another begins.

        Role: any.
        """
        result: Health = await self.ask(Request("GET", "/health", Health))
        return result

    async def get_intention(self) -> IntentionReport:
        """The intention and its reasons.

        The strategies at work, the filters they set, Ω, what they use of each resource, and for each desired
        class the reason why it gets what it gets.

        Role: spectator.
        """
        result: IntentionReport = await self.ask(Request("GET", "/intention", IntentionReport))
        return result

    async def get_lanes(
        self, *, from_: float | None = None, to: float | None = None, points: int | None = None
    ) -> LanesPast:
        """What the lanes were.

        The last hour is kept, twice a second, and of a recording what was played. Where that is more than
        `points` it is put into buckets of equal width; a closing shorter than a bucket stays among the `changes`.

        Role: spectator.
        """
        result: LanesPast = await self.ask(
            Request("GET", "/lanes", LanesPast, query={"from": from_, "to": to, "points": points})
        )
        return result

    async def get_link(self) -> LinkReport:
        """How the link to the pages is shaped, for tests.

        Role: spectator.
        """
        result: LinkReport = await self.ask(Request("GET", "/link", LinkReport))
        return result

    async def get_map(self) -> CurrentMap:
        """The map in use.

        Role: spectator.
        """
        result: CurrentMap = await self.ask(Request("GET", "/map", CurrentMap))
        return result

    async def get_map_picture(self, name: str) -> bytes:
        """A map's picture.

        One pixel a cell; its top row has the greatest y.

        Role: spectator.
        """
        result: bytes = await self.ask(Request("GET", f"/maps/{Request.quoted(name)}/picture", bytes))
        return result

    async def get_memory(self) -> MemoryReport:
        """Export what is remembered.

        All episodes, those that happened last first, and their events. Of people, it has numbers alone. Refused
        where memory is off.

        Role: spectator.
        """
        result: MemoryReport = await self.ask(Request("GET", "/memory", MemoryReport))
        return result

    async def get_module(self, name: str) -> ModuleReport:
        """One module.

        Role: spectator.
        """
        result: ModuleReport = await self.ask(Request("GET", f"/modules/{Request.quoted(name)}", ModuleReport))
        return result

    async def get_percepts(self) -> PlacedPercepts:
        """Faces, sounds, loud noises, codes.

        The same as `perceived` on the live stream. What attention has closed is not perceived.

        Role: spectator.
        """
        result: PlacedPercepts = await self.ask(Request("GET", "/percepts", PlacedPercepts))
        return result

    async def get_place(self, place_id: str) -> PlaceReport:
        """One place.

        Role: spectator.
        """
        result: PlaceReport = await self.ask(Request("GET", f"/places/{Request.quoted(place_id)}", PlaceReport))
        return result

    async def get_playback(self) -> PlaybackReport:
        """State of the playback.

        Role: spectator.
        """
        result: PlaybackReport = await self.ask(Request("GET", "/playback", PlaybackReport))
        return result

    async def get_rehearsal(self) -> RehearsalReport:
        """The rehearsal under way, or the last.

        How far it is; once it is `done`, what was said and done when, where the robot was, and what went wrong.

        Role: spectator.
        """
        result: RehearsalReport = await self.ask(Request("GET", "/tour-rehearsal", RehearsalReport))
        return result

    async def get_robot(self) -> RobotReport:
        """State of the robot: pose, guard, driver.

        Role: spectator.
        """
        result: RobotReport = await self.ask(Request("GET", "/robot", RobotReport))
        return result

    async def get_scene(self) -> SceneAddress:
        """Where the 3D view for a page's frame is.

        Its address on the port of the 3D view, for a client that reached the console under this request's `Host`.
        Where that names another port than the console's own, as behind a proxy, the second port's address is not
        known, and the view is at `/viser/` here.

        Role: spectator.
        """
        result: SceneAddress = await self.ask(Request("GET", "/scene", SceneAddress))
        return result

    async def get_session(self) -> Session:
        """Check the login.

        200 if this client may use the console; 401 where it must log in.

        Role: any.
        """
        result: Session = await self.ask(Request("GET", "/session", Session))
        return result

    async def get_timeline(
        self,
        *,
        since: float | None = None,
        until: float | None = None,
        kinds: str | None = None,
        after_id: int | None = None,
        limit: int | None = None,
    ) -> EventList:
        """Events of the timeline.

        Oldest first. To follow it, ask again with `after_id` of the last one had.

        Role: spectator.
        """
        result: EventList = await self.ask(
            Request(
                "GET",
                "/timeline",
                EventList,
                query={"since": since, "until": until, "kinds": kinds, "after_id": after_id, "limit": limit},
            )
        )
        return result

    async def get_tour(self, tour_id: str) -> TourReport:
        """One tour.

        Role: spectator.
        """
        result: TourReport = await self.ask(Request("GET", f"/tours/{Request.quoted(tour_id)}", TourReport))
        return result

    async def get_tour_media(self, file: str) -> bytes:
        """A picture or a video.

        Whole, or in part (`Range`).

        Role: spectator.
        """
        result: bytes = await self.ask(Request("GET", f"/tour-media/{Request.quoted(file)}", bytes))
        return result

    async def get_tour_posters(
        self,
        tour_id: str,
        *,
        paper: Literal["a4", "letter"] | None = None,
        language: str | None = None,
        stop: str | None = None,
    ) -> bytes:
        """Print posters.

        Of the stops that have the text of a `poster`.

        Role: spectator.
        """
        result: bytes = await self.ask(
            Request(
                "GET",
                f"/tours/{Request.quoted(tour_id)}/posters.pdf",
                bytes,
                query={"paper": paper, "language": language, "stop": stop},
            )
        )
        return result

    async def get_tour_report(self, run_id: str) -> RunReport:
        """One report on a tour.

        Role: spectator.
        """
        result: RunReport = await self.ask(Request("GET", f"/tour-reports/{Request.quoted(run_id)}", RunReport))
        return result

    async def get_tour_run(self) -> TourRunReport:
        """The tour under way.

        How it goes, and what the run has been so far; of the last one after its end.

        Role: spectator.
        """
        result: TourRunReport = await self.ask(Request("GET", "/tour-run", TourRunReport))
        return result

    async def get_tour_schema(self) -> Any:
        """The JSON Schema of a tour.

        Draft 2020-12. What it cannot say, `POST /tours/validate` finds.

        Role: spectator.
        """
        result: Any = await self.ask(Request("GET", "/tour-schema", Any))
        return result

    async def get_visitor_link(self) -> VisitorLink:
        """The link for visitors' phones.

        For operators: the page for visitors with the key of this run, and its QR code. The key changes with each
        run, and opens nothing but that page.

        Role: operator.
        """
        result: VisitorLink = await self.ask(Request("GET", "/tour-run/visitors", VisitorLink))
        return result

    async def get_visitor_media(self, file: str) -> bytes:
        """A picture or a video of the tour.

        Only what the tour under way names, out of the folder of tours; also in part (`Range`).

        Role: spectator.
        """
        result: bytes = await self.ask(Request("GET", f"/visitor/media/{Request.quoted(file)}", bytes))
        return result

    async def get_webhook(self, webhook_id: str) -> WebhookReport:
        """One webhook.

        Role: supervisor.
        """
        result: WebhookReport = await self.ask(Request("GET", f"/webhooks/{Request.quoted(webhook_id)}", WebhookReport))
        return result

    async def get_zones(self) -> ZoneList:
        """Zones of the map in use.

        Role: spectator.
        """
        result: ZoneList = await self.ask(Request("GET", "/map/zones", ZoneList))
        return result

    async def import_tour(
        self,
        body: str | bytes,
        *,
        if_match: str | None = None,
        media: Literal["application/yaml", "application/zip"] = "application/yaml",
    ) -> TourReport:
        """Import a tour's file.

        YAML, as `GET /tours/{tour_id}/file` gives it (or JSON, which is YAML), or the archive of `GET
        /tours/{tour_id}/archive`, under the id in it. With `If-Match` it replaces the tour of this id (200);
        without, that is refused. The media of an archive are kept with the tour or not at all; where another
        picture has a name, the tour names the new one.

        Role: operator.
        """
        result: TourReport = await self.ask(
            Request("POST", "/tours/import", TourReport, body=body, media=media, headers={"If-Match": if_match})
        )
        return result

    async def latch_e_stop(self) -> EStop:
        """Latch the emergency stop.

        Latches the emergency stop in the guard: the wheels are commanded to zero until it is released here or on
        the page. Answers once the guard has confirmed it. Needs no body. May be repeated.

        Role: spectator.
        """
        result: EStop = await self.ask(Request("POST", "/stop", EStop))
        return result

    async def list_channels(self) -> ChannelList:
        """Channels, their freshness and counters.

        Role: spectator.
        """
        result: ChannelList = await self.ask(Request("GET", "/channels", ChannelList))
        return result

    async def list_desire_classes(self) -> DesireClassList:
        """List all desire classes.

        Each class with the JSON Schema of its parameters: enough to build a form from.

        Role: spectator.
        """
        result: DesireClassList = await self.ask(Request("GET", "/desire-classes", DesireClassList))
        return result

    async def list_desires(self) -> Desires:
        """List all desires.

        With what has become of each so far: intended, exploited, and since when (`progress`).

        Role: spectator.
        """
        result: Desires = await self.ask(Request("GET", "/desires", Desires))
        return result

    async def list_maps(self) -> MapList:
        """List all maps.

        By name; and the one in use, which may have no name yet.

        Role: spectator.
        """
        result: MapList = await self.ask(Request("GET", "/maps", MapList))
        return result

    async def list_modules(self) -> ModuleList:
        """Modules, their load and counters.

        Role: spectator.
        """
        result: ModuleList = await self.ask(Request("GET", "/modules", ModuleList))
        return result

    async def list_places(self) -> PlaceList:
        """List all places of the map in use.

        In the order of their making; each with its `etag`.

        Role: spectator.
        """
        result: PlaceList = await self.ask(Request("GET", "/places", PlaceList))
        return result

    async def list_recordings(self) -> RecordingList:
        """List all recordings.

        The newest first, with the room left on the disk and what the Recorder does.

        Role: spectator.
        """
        result: RecordingList = await self.ask(Request("GET", "/recordings", RecordingList))
        return result

    async def list_resources(self) -> ResourceList:
        """Resources: budgets and use.

        Role: spectator.
        """
        result: ResourceList = await self.ask(Request("GET", "/resources", ResourceList))
        return result

    async def list_rules(self) -> RulesReport:
        """Rules, and when each applied last.

        The rules by which something is desired without code, in force now. Where a file was changed and has a
        mistake, `problem` says which, and the rules are still those before. No rules: the program has none.

        Role: spectator.
        """
        result: RulesReport = await self.ask(Request("GET", "/rules", RulesReport))
        return result

    async def list_strategies(self) -> StrategyList:
        """List all strategies.

        Role: spectator.
        """
        result: StrategyList = await self.ask(Request("GET", "/strategies", StrategyList))
        return result

    async def list_tour_media(self) -> TourMediaList:
        """List pictures and videos of tours.

        All that tours can show, by name, with the tours that do.

        Role: spectator.
        """
        result: TourMediaList = await self.ask(Request("GET", "/tour-media", TourMediaList))
        return result

    async def list_tour_reports(self, *, tour: str | None = None) -> RunReportList:
        """List reports on tours.

        The newest first. Of people, they have counts alone.

        Role: spectator.
        """
        result: RunReportList = await self.ask(Request("GET", "/tour-reports", RunReportList, query={"tour": tour}))
        return result

    async def list_tours(self) -> TourList:
        """List all tours.

        By id, those that come with the program among them; each with its `etag`.

        Role: spectator.
        """
        result: TourList = await self.ask(Request("GET", "/tours", TourList))
        return result

    async def list_viewers(self) -> ViewerList:
        """Connected pages and 3D views, and their connections.

        Role: spectator.
        """
        result: ViewerList = await self.ask(Request("GET", "/viewers", ViewerList))
        return result

    async def list_webhooks(self) -> WebhookList:
        """List all webhooks.

        In the order of their making, with how their deliveries go; without their secrets.

        Role: supervisor.
        """
        result: WebhookList = await self.ask(Request("GET", "/webhooks", WebhookList))
        return result

    async def load_map(self, name: str, body: LoadRequest | None = None) -> CurrentMap:
        """Take a map into use.

        In place of the one in use, which is lost if it was not saved. Needs no body: the robot then looks for
        itself on the map, and the map stays as it is. Every goal is withdrawn: it was a place on the other map.

        Role: supervisor.
        """
        result: CurrentMap = await self.ask(
            Request("POST", f"/maps/{Request.quoted(name)}/load", CurrentMap, body=body)
        )
        return result

    async def log_in(self, body: LoginRequest) -> Session:
        """Log in.

        Begins a session and sets its cookie, which no script can read and no other site can use, until the
        browser is closed. The session is over when nothing was asked in it for 12 hours, at the logout, or with
        the console. It has the role of the password; with the token it is a supervisor's. After five wrong tokens
        an address waits, longer with each further one.

        Role: any.
        """
        result: Session = await self.ask(Request("POST", "/session", Session, body=body))
        return result

    async def log_out(self) -> None:
        """Log out.

        Ends this browser's session, and its WebSockets.

        Role: any.
        """

        await self.ask(Request("DELETE", "/session", None))

    async def place_robot(self, body: PoseRequest) -> CurrentMap:
        """Set the robot's pose on the map.

        On the map in use, within 1 m and 0.5 rad; from there its pose is refined by what the laser sees.

        Role: operator.
        """
        result: CurrentMap = await self.ask(Request("PUT", "/map/pose", CurrentMap, body=body))
        return result

    async def plan_route(self, body: RouteRequest) -> RouteReport:
        """Plan a route.

        Leg by leg, by the robot's own planner, on the map in use, its zones and what it keeps in mind of
        obstacles; what is there for the moment does not count. Nothing moves. A leg that cannot be driven says
        why.

        Role: spectator.
        """
        result: RouteReport = await self.ask(Request("POST", "/map/route", RouteReport, body=body))
        return result

    async def press_as_visitor(self, body: VisitorPress) -> None:
        """Press as a visitor.

        A `button` that the tour waits for, or a question that may be asked now.

        Role: operator.
        """

        await self.ask(Request("POST", "/visitor/press", None, body=body))

    async def press_tour(self, body: TourPress) -> TourRunReport:
        """Steer the tour under way.

        A `button` (`pause`, `resume`, `skip`, `undo_skip`, `repeat`, `retry`, `end`, and the visitors' `agree`,
        `decline`, `next`), a `stop` to go to, or a question that a visitor asks. What does nothing now is
        refused; the answer's `buttons` are those that do.

        Role: operator.
        """
        result: TourRunReport = await self.ask(Request("POST", "/tour-run/press", TourRunReport, body=body))
        return result

    async def put_link(self, body: LinkChange) -> LinkReport:
        """Shape the link to the pages, for tests.

        Delays and bounds every stream between the program and its pages from now on, this answer included: live
        stream, 3D view, REST. `{}` ends it. Streams are ordered, so nothing is lost: a lost packet is sent again,
        and what follows it waits.

        Role: supervisor.
        """
        result: LinkReport = await self.ask(Request("PUT", "/link", LinkReport, body=body))
        return result

    async def redo_tour(self, tour_id: str, *, if_match: str | None = None) -> TourReport | None:
        """Do again what was undone last.

        Needs no body.

        Role: operator.
        """
        result: TourReport | None = await self.ask(
            Request("POST", f"/tours/{Request.quoted(tour_id)}/redo", TourReport | None, headers={"If-Match": if_match})
        )
        return result

    async def release_e_stop(self, *, seen: float | None = None) -> EStop:
        """Release the emergency stop.

        A stop that was pressed after `seen` stays latched, so that a late release does not undo a stop that its
        sender has not seen. The base stays still until the next fresh command. Answers once the guard has
        confirmed it, or half a second later: a goal that is given next is not refused for a latch that is gone.
        An operator releases what no other pressed, a supervisor any stop.

        Role: operator.
        """
        result: EStop = await self.ask(Request("DELETE", "/stop", EStop, query={"seen": seen}))
        return result

    async def remove_desire(self, desire_id: str) -> None:
        """Remove a desire.

        Role: operator.
        """

        await self.ask(Request("DELETE", f"/desires/{Request.quoted(desire_id)}", None))

    async def rename_map(self, name: str, body: RenameRequest) -> KeptMap:
        """Rename a map.

        A name that another map has is refused. The map in use is saved under its new name as it is now.

        Role: supervisor.
        """
        result: KeptMap = await self.ask(Request("PATCH", f"/maps/{Request.quoted(name)}", KeptMap, body=body))
        return result

    async def replace_place(self, place_id: str, body: PlaceReplacement, *, if_match: str | None = None) -> PlaceReport:
        """Replace a place, or create it under this id.

        Without a name it keeps the one that it has. With `If-Match`, nothing is created.

        Role: operator.
        """
        result: PlaceReport = await self.ask(
            Request(
                "PUT", f"/places/{Request.quoted(place_id)}", PlaceReport, body=body, headers={"If-Match": if_match}
            )
        )
        return result

    async def replace_tour(self, tour_id: str, body: dict[str, Any], *, if_match: str | None = None) -> TourReport:
        """Replace a tour, or create it under this id.

        The id in it may be left out. With `If-Match`, nothing is created.

        Role: operator.
        """
        result: TourReport = await self.ask(
            Request("PUT", f"/tours/{Request.quoted(tour_id)}", TourReport, body=body, headers={"If-Match": if_match})
        )
        return result

    async def replay_recording(self, name: str) -> ReplayReport:
        """Replay a recording.

        Starts `hbba replay` with a console of its own and answers once that is up, within seconds. A replay
        started here before is ended. It ends with this console, and by itself three minutes after its last viewer
        left.

        Role: operator.
        """
        result: ReplayReport = await self.ask(
            Request("POST", f"/recordings/{Request.quoted(name)}/replay", ReplayReport)
        )
        return result

    async def save_map(self, name: str) -> KeptMap:
        """Keep the map in use.

        Under this name, which it has from then on; an older map of this name is replaced. Needs no body.

        Role: supervisor.
        """
        result: KeptMap = await self.ask(Request("PUT", f"/maps/{Request.quoted(name)}", KeptMap))
        return result

    async def save_ring(self, body: SaveRequest | None = None) -> Saved:
        """Keep the ring's last minutes.

        Makes a recording of what the ring holds; the ring goes on. Needs no body.

        Role: operator.
        """
        result: Saved = await self.ask(Request("POST", "/recordings/save", Saved, body=body))
        return result

    async def search_robot(self) -> CurrentMap:
        """Start global localization.

        It is somewhere on the map in use, and finds out where. Needs no body.

        Role: operator.
        """
        result: CurrentMap = await self.ask(Request("POST", "/map/search", CurrentMap))
        return result

    async def set_goal(self, body: GoalRequest) -> Desire:
        """Send the robot somewhere.

        Creates a desire of class GoTo, or changes the one that was created so before: there is one goal of people
        at a time, and a second takes the first one's place. Attention weighs it as any other; how the robot does
        is in `navigation` of GET /goal and of the live stream. The same goal again changes nothing. A goal by
        `place` is the pose that the place has now; one in an obstacle of the map or in a keep-out zone is
        refused.

        Role: operator.
        """
        result: Desire = await self.ask(Request("PUT", "/goal", Desire, body=body))
        return result

    async def set_zones(self, body: ZonesRequest) -> ZoneList:
        """Draw the zones of the map in use.

        All of them: what is not named is gone. They are kept with the map at once if it has a name.

        Role: operator.
        """
        result: ZoneList = await self.ask(Request("PUT", "/map/zones", ZoneList, body=body))
        return result

    async def start_recording(self, body: NewRecording | None = None, *, idempotency_key: str | None = None) -> Desire:
        """Start recording.

        Creates a desire of class Record; attention weighs it as any other. Whether it records, and if not why, is
        in `recorder` of the list and on the live stream. Needs no body.

        Refused while a recording runs that was asked for here; a ring gives way, and what it held is kept as a
        recording of its own.

        Role: operator.
        """
        result: Desire = await self.ask(
            Request("POST", "/recordings", Desire, body=body, headers={"idempotency-key": idempotency_key})
        )
        return result

    async def start_rehearsal(self, tour_id: str, body: NewRehearsal) -> RehearsalReport:
        """Rehearse a tour.

        Plays the tour as it is kept on its map, without the robot, in a process of its own: the robot may be
        driven meanwhile. Follow it by `GET /tour-rehearsal`.

        Role: operator.
        """
        result: RehearsalReport = await self.ask(
            Request("POST", f"/tours/{Request.quoted(tour_id)}/rehearsal", RehearsalReport, body=body)
        )
        return result

    async def start_tour(self, tour_id: str, body: NewTourRun) -> TourRunReport:
        """Begin a tour.

        Now, or when visitors come. Refused while another is under way, while the robot is held, and where the
        tour lacks something that it needs (`errors` of its `problems`).

        Role: operator.
        """
        result: TourRunReport = await self.ask(
            Request("POST", f"/tours/{Request.quoted(tour_id)}/run", TourRunReport, body=body)
        )
        return result

    async def step_playback(self) -> PlaybackReport:
        """Step to the next image.

        To the next image of the first camera; in a recording without images to the next scan, without scans by
        0.1 s. Answers once the modules have done with it.

        Role: operator.
        """
        result: PlaybackReport = await self.ask(Request("POST", "/playback/step", PlaybackReport))
        return result

    async def stop_recording(self) -> Withdrawn:
        """Stop recording.

        Withdraws every desire of class Record that came over the console. Needs no body. May be repeated.

        Role: operator.
        """
        result: Withdrawn = await self.ask(Request("POST", "/recordings/stop", Withdrawn))
        return result

    async def try_webhook(self, webhook_id: str) -> WebhookTrial:
        """Post an event for a trial.

        Posts one event, whose `data.data.trial` is true, once, and answers with what became of it.

        Role: supervisor.
        """
        result: WebhookTrial = await self.ask(
            Request("POST", f"/webhooks/{Request.quoted(webhook_id)}/trial", WebhookTrial)
        )
        return result

    async def undo_tour(
        self, tour_id: str, *, to_begin: bool | None = None, if_match: str | None = None
    ) -> TourReport | None:
        """Undo the newest change of a tour.

        Anyone's, since the program began: edits, deletion, import, and what a text editor changed in the file.
        Needs no body.

        Role: operator.
        """
        result: TourReport | None = await self.ask(
            Request(
                "POST",
                f"/tours/{Request.quoted(tour_id)}/undo",
                TourReport | None,
                query={"to_begin": to_begin},
                headers={"If-Match": if_match},
            )
        )
        return result

    async def validate_tour(self, body: dict[str, Any]) -> TourVerdict:
        """Check a tour.

        Without keeping it. Every mistake is found, with what else it lacks to run on this robot.

        Role: spectator.
        """
        result: TourVerdict = await self.ask(Request("POST", "/tours/validate", TourVerdict, body=body))
        return result

/** The operations of REST. Written by `make types` from the program's own description; change that, not this file. */

import type { Request } from "./request.js";
import type {
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
  EStop,
  EmotionState,
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
  PlaceList,
  PlaceReplacement,
  PlaceReport,
  PlacedPercepts,
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
  SaveRequest,
  Saved,
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
} from "./records.js";

/** What the program can be asked for; each method says which role may. */
export abstract class Operations {
  /** The answer to `request`. Throws Problem for a refusal. */
  protected abstract ask<T>(request: Request): Promise<T>;

  /**
   * Hand in a picture or a video. The file itself is the body. What it is, its content says: JPEG, PNG, WebP, GIF, MP4
   * or WebM, and whole. `file` of the answer is what a tour's `show` names it: made of `name`, with a number where
   * another has it. Role: operator.
   */
  addTourMedia(body: ArrayBuffer, options: { name?: string; media?: "image/gif" | "image/jpeg" | "image/png" | "image/webp" | "video/mp4" | "video/webm" } = {}): Promise<TourMedia> {
    return this.ask<TourMedia>({ method: "POST", path: `/tour-media`, answer: "json", body, media: options.media ?? "image/gif", query: { "name": options.name } });
  }

  /**
   * What would be chosen. The intention under other desires, costs and budgets, with its reasons. The robot goes on as
   * it is. One is answered at a time; `stamp` is when it was asked. Role: operator.
   */
  askWhatIf(body: WhatIf): Promise<IntentionReport> {
    return this.ask<IntentionReport>({ method: "POST", path: `/intention/what-if`, answer: "json", body });
  }

  /**
   * Begin an empty map. Without a name, the robot at its origin. The one in use is lost if it was not saved, and a goal
   * on it withdrawn. Needs no body. Role: supervisor.
   */
  beginMap(): Promise<CurrentMap> {
    return this.ask<CurrentMap>({ method: "POST", path: `/map/begin`, answer: "json" });
  }

  /**
   * Cancel the goal. Withdraws every desire of class GoTo that came over the console, and every one to dock or to
   * explore, also the robot's own; a goal that the robot gave up is no longer reported. A guided tour on its way is
   * paused. May be repeated. Role: operator.
   */
  cancelGoal(): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/goal`, answer: "nothing" });
  }

  /** Cancel the rehearsal, or forget it. There is none afterwards; also where there was none. Role: operator. */
  cancelRehearsal(): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/tour-rehearsal`, answer: "nothing" });
  }

  /**
   * Change a desire in place. Members left out stay. `params` replaces all parameters, and may name a `place` as for a
   * new desire; `ttl` counts from now, null makes it stay. Role: operator.
   */
  changeDesire(desireId: string, body: DesireChange): Promise<Desire> {
    return this.ask<Desire>({ method: "PATCH", path: `/desires/${encodeURIComponent(desireId)}`, answer: "json", body });
  }

  /**
   * Rename or move a place. Members left out stay, and its id does. A place that is moved by hand follows no poster
   * from then on. Role: operator.
   */
  changePlace(placeId: string, body: PlaceChange, options: { ifMatch?: string | null } = {}): Promise<PlaceReport> {
    return this.ask<PlaceReport>({ method: "PATCH", path: `/places/${encodeURIComponent(placeId)}`, answer: "json", body, headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Play, pause, seek, change the speed. Members left out stay. Answers once it is so: after a seek, when the scene
   * there is shown. Of several seeks at once only the newest is gone to, and all are answered then. A position beyond
   * an end is that end; to play from the end is to begin again. Role: operator.
   */
  changePlayback(body: PlaybackChange): Promise<PlaybackReport> {
    return this.ask<PlaybackReport>({ method: "PATCH", path: `/playback`, answer: "json", body });
  }

  /**
   * Change a budget. Attention selects again within the new budget at once; it lasts until changed again or the program
   * ends. Role: operator.
   */
  changeResource(name: string, body: ResourceChange): Promise<ResourceReport> {
    return this.ask<ResourceReport>({ method: "PATCH", path: `/resources/${encodeURIComponent(name)}`, answer: "json", body });
  }

  /**
   * Change a tour. A JSON Merge Patch (RFC 7396): members left out stay, null gives a member its usual value, a list is
   * replaced as a whole. An id does not change. Role: operator.
   */
  changeTour(tourId: string, body: Record<string, unknown>, options: { ifMatch?: string | null } = {}): Promise<TourReport> {
    return this.ask<TourReport>({ method: "PATCH", path: `/tours/${encodeURIComponent(tourId)}`, answer: "json", body, headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Check whether a visitor has entered. 204 for one that may see the tour, an operator's browser among them. Role:
   * any.
   */
  checkVisitor(): Promise<void> {
    return this.ask<void>({ method: "GET", path: `/visitor/session`, answer: "nothing" });
  }

  /**
   * Create a desire. Attention weighs it at once: the intention that follows is on the live stream and in `GET
   * /intention`. A desire with a `ttl` expires by itself, so that a client that dies leaves nothing behind. Refused
   * while there are 1000 desires from the console. `params` of GoTo may be a `place` of the map, by its id, instead of
   * coordinates. Role: operator.
   */
  createDesire(body: NewDesire, options: { idempotencyKey?: string | null } = {}): Promise<Desire> {
    return this.ask<Desire>({ method: "POST", path: `/desires`, answer: "json", body, headers: { "idempotency-key": options.idempotencyKey } });
  }

  /**
   * Create a place. By its coordinates (`pose`), where the robot is (`here`), or in front of a `poster`: 1.2 m from it
   * along its normal, looking at it. It is kept with the map at once if that has a name. One where the robot cannot
   * stand is taken, and says so in its `problem`. Role: operator.
   */
  createPlace(body: NewPlace): Promise<PlaceReport> {
    return this.ask<PlaceReport>({ method: "POST", path: `/places`, answer: "json", body });
  }

  /**
   * Create a tour. Under the id in it. What it refers to need not exist yet: the `problems` say what it lacks to run.
   * Role: operator.
   */
  createTour(body: Record<string, unknown>): Promise<TourReport> {
    return this.ask<TourReport>({ method: "POST", path: `/tours`, answer: "json", body });
  }

  /**
   * Have events posted to a URL. From now on each event of these `kinds` is posted to `url`, in order, one at a time,
   * signed as the specification Standard Webhooks 1.0 says, until the receiver answers 2xx: again after 1 s, 5 s, 30 s,
   * 2 min, and then every 10 min for a day. A receiver that answers 410 gets nothing more. `secret` is answered once.
   * Role: supervisor.
   */
  createWebhook(body: NewWebhook): Promise<NewWebhookReport> {
    return this.ask<NewWebhookReport>({ method: "POST", path: `/webhooks`, answer: "json", body });
  }

  /** Delete an episode. With the events that were its own. Role: supervisor. */
  deleteEpisode(episode: number): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/memory/episodes/${encodeURIComponent(episode)}`, answer: "nothing" });
  }

  /** Delete a map. For good, with its zones. The map in use is refused. Role: supervisor. */
  deleteMap(name: string): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/maps/${encodeURIComponent(name)}`, answer: "nothing" });
  }

  /**
   * Delete all that is remembered. Also what is under way. What is deleted is overwritten on the disk. Role:
   * supervisor.
   */
  deleteMemory(): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/memory`, answer: "nothing" });
  }

  /** Delete a place. Goals that were given by it stay: they are its pose. Role: operator. */
  deletePlace(placeId: string, options: { ifMatch?: string | null } = {}): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/places/${encodeURIComponent(placeId)}`, answer: "nothing", headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Delete a recording. For good. One that is being written is refused: stop first; so is one that is being replayed,
   * here or in a replay that was started here: end that first. Role: supervisor.
   */
  deleteRecording(name: string): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/recordings/${encodeURIComponent(name)}`, answer: "nothing" });
  }

  /**
   * Delete a tour. `POST /tours/{tour_id}/undo` brings it back until the program ends. Where it was a changed tour of
   * the program's, that one is there again; the program's own are not deleted. Role: supervisor.
   */
  deleteTour(tourId: string, options: { ifMatch?: string | null } = {}): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/tours/${encodeURIComponent(tourId)}`, answer: "nothing", headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Delete a picture or a video. For good; `undo` of a tour does not bring it back. One that a tour shows is not
   * deleted. Role: operator.
   */
  deleteTourMedia(file: string): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/tour-media/${encodeURIComponent(file)}`, answer: "nothing" });
  }

  /** Delete a report. Role: supervisor. */
  deleteTourReport(runId: string): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/tour-reports/${encodeURIComponent(runId)}`, answer: "nothing" });
  }

  /** Remove a webhook. Nothing more is posted; events that wait are given up. Role: supervisor. */
  deleteWebhook(webhookId: string): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/webhooks/${encodeURIComponent(webhookId)}`, answer: "nothing" });
  }

  /** Wait for visitors no more. A tour that is under way is ended by its button `end` before. Role: operator. */
  dismissTour(): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/tour-run`, answer: "nothing" });
  }

  /** End a replay. Role: operator. */
  endReplay(name: string): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/recordings/${encodeURIComponent(name)}/replay`, answer: "nothing" });
  }

  /**
   * Enter as a visitor. With the key of the link. Sets a cookie, which no script can read and which is sent below
   * `/visitor` alone; it is over with the run. Role: any.
   */
  enterAsVisitor(body: VisitorKey): Promise<void> {
    return this.ask<void>({ method: "POST", path: `/visitor/session`, answer: "nothing", body });
  }

  /** Export a tour's file. Without pictures and videos. Role: spectator. */
  exportTour(tourId: string): Promise<string> {
    return this.ask<string>({ method: "GET", path: `/tours/${encodeURIComponent(tourId)}/file`, answer: "text" });
  }

  /**
   * Export a tour with its pictures and videos. A ZIP archive of the tour's file and what it shows, without what is
   * missing. Role: spectator.
   */
  exportTourArchive(tourId: string): Promise<ArrayBuffer> {
    return this.ask<ArrayBuffer>({ method: "GET", path: `/tours/${encodeURIComponent(tourId)}/archive`, answer: "bytes" });
  }

  /** Export reports on tours as a table. A line for each stop; times are UTC. Role: spectator. */
  exportTourReports(options: { tour?: string | null } = {}): Promise<string> {
    return this.ask<string>({ method: "GET", path: `/tour-reports.csv`, answer: "text", query: { "tour": options.tour } });
  }

  /**
   * A point of the picture on the map. Where that is on the map, which the robot saw there when the picture was taken.
   * Role: spectator.
   */
  findCameraPoint(body: CameraClick): Promise<CameraPoint> {
    return this.ask<CameraPoint>({ method: "POST", path: `/camera/point`, answer: "json", body });
  }

  /**
   * What a point of a 3D view shows. The first thing on the ray of that view's camera, as it is drawn there: a poster,
   * the map's walls, what the depth camera saw, or the floor; and where that is. Role: spectator.
   */
  findScenePoint(body: SceneClick): Promise<ScenePoint> {
    return this.ask<ScenePoint>({ method: "POST", path: `/scene/point`, answer: "json", body });
  }

  /**
   * One desire, and what became of it. A desire that left is kept for ten minutes, of the last 2000. Where more than 24
   * requests wait, the one that has waited longest is answered at once. Role: spectator.
   */
  getDesire(desireId: string, options: { wait?: number } = {}): Promise<DesireReport> {
    return this.ask<DesireReport>({ method: "GET", path: `/desires/${encodeURIComponent(desireId)}`, answer: "json", query: { "wait": options.wait } });
  }

  /** One desire class. Role: spectator. */
  getDesireClass(name: string): Promise<DesireClassReport> {
    return this.ask<DesireClassReport>({ method: "GET", path: `/desire-classes/${encodeURIComponent(name)}`, answer: "json" });
  }

  /**
   * What the robot feels, and why. Joy, anger, sadness and fear, each with the desire classes that it comes from, and
   * the desires whose intensity is raised. A program without emotions feels nothing. Role: spectator.
   */
  getEmotions(): Promise<EmotionState> {
    return this.ask<EmotionState>({ method: "GET", path: `/emotions`, answer: "json" });
  }

  /**
   * The robots of the fleet: state, and who drives. This robot, and those of the file of `hbba run --fleet`, whose
   * consoles are asked now: one that does not answer within 2 s is `unreachable`. Role: spectator.
   */
  getFleet(): Promise<FleetReport> {
    return this.ask<FleetReport>({ method: "GET", path: `/fleet`, answer: "json" });
  }

  /**
   * The goal and the state of navigation. What is desired, and what the behavior that goes there is about. Role:
   * spectator.
   */
  getGoal(): Promise<Goal> {
    return this.ask<Goal>({ method: "GET", path: `/goal`, answer: "json" });
  }

  /**
   * Health of the program. Open to all; `degraded` while a module does not run, the body is silent, or a recording has
   * ended by itself, until that is stopped (`POST /recordings/stop`) or another begins. Role: any.
   */
  getHealth(): Promise<Health> {
    return this.ask<Health>({ method: "GET", path: `/health`, answer: "json" });
  }

  /**
   * The intention and its reasons. The strategies at work, the filters they set, Ω, what they use of each resource, and
   * for each desired class the reason why it gets what it gets. Role: spectator.
   */
  getIntention(): Promise<IntentionReport> {
    return this.ask<IntentionReport>({ method: "GET", path: `/intention`, answer: "json" });
  }

  /**
   * What the lanes were. The last hour is kept, twice a second, and of a recording what was played. Where that is more
   * than `points` it is put into buckets of equal width; a closing shorter than a bucket stays among the `changes`.
   * Role: spectator.
   */
  getLanes(options: { from?: number | null; to?: number | null; points?: number } = {}): Promise<LanesPast> {
    return this.ask<LanesPast>({ method: "GET", path: `/lanes`, answer: "json", query: { "from": options.from, "to": options.to, "points": options.points } });
  }

  /** How the link to the pages is shaped, for tests. Role: spectator. */
  getLink(): Promise<LinkReport> {
    return this.ask<LinkReport>({ method: "GET", path: `/link`, answer: "json" });
  }

  /** The map in use. Role: spectator. */
  getMap(): Promise<CurrentMap> {
    return this.ask<CurrentMap>({ method: "GET", path: `/map`, answer: "json" });
  }

  /** A map's picture. One pixel a cell; its top row has the greatest y. Role: spectator. */
  getMapPicture(name: string): Promise<ArrayBuffer> {
    return this.ask<ArrayBuffer>({ method: "GET", path: `/maps/${encodeURIComponent(name)}/picture`, answer: "bytes" });
  }

  /**
   * Export what is remembered. All episodes, those that happened last first, and their events. Of people, it has
   * numbers alone. Refused where memory is off. Role: spectator.
   */
  getMemory(): Promise<MemoryReport> {
    return this.ask<MemoryReport>({ method: "GET", path: `/memory`, answer: "json" });
  }

  /** One module. Role: spectator. */
  getModule(name: string): Promise<ModuleReport> {
    return this.ask<ModuleReport>({ method: "GET", path: `/modules/${encodeURIComponent(name)}`, answer: "json" });
  }

  /**
   * Faces, sounds, loud noises, codes. The same as `perceived` on the live stream. What attention has closed is not
   * perceived. Role: spectator.
   */
  getPercepts(): Promise<PlacedPercepts> {
    return this.ask<PlacedPercepts>({ method: "GET", path: `/percepts`, answer: "json" });
  }

  /** One place. Role: spectator. */
  getPlace(placeId: string): Promise<PlaceReport> {
    return this.ask<PlaceReport>({ method: "GET", path: `/places/${encodeURIComponent(placeId)}`, answer: "json" });
  }

  /** State of the playback. Role: spectator. */
  getPlayback(): Promise<PlaybackReport> {
    return this.ask<PlaybackReport>({ method: "GET", path: `/playback`, answer: "json" });
  }

  /**
   * The rehearsal under way, or the last. How far it is; once it is `done`, what was said and done when, where the
   * robot was, and what went wrong. Role: spectator.
   */
  getRehearsal(): Promise<RehearsalReport> {
    return this.ask<RehearsalReport>({ method: "GET", path: `/tour-rehearsal`, answer: "json" });
  }

  /** State of the robot: pose, guard, driver. Role: spectator. */
  getRobot(): Promise<RobotReport> {
    return this.ask<RobotReport>({ method: "GET", path: `/robot`, answer: "json" });
  }

  /**
   * Where the 3D view for a page's frame is. Its address on the port of the 3D view, for a client that reached the
   * console under this request's `Host`. Where that names another port than the console's own, as behind a proxy, the
   * second port's address is not known, and the view is at `/viser/` here. Role: spectator.
   */
  getScene(): Promise<SceneAddress> {
    return this.ask<SceneAddress>({ method: "GET", path: `/scene`, answer: "json" });
  }

  /** Check the login. 200 if this client may use the console; 401 where it must log in. Role: any. */
  getSession(): Promise<Session> {
    return this.ask<Session>({ method: "GET", path: `/session`, answer: "json" });
  }

  /**
   * Events of the timeline. Oldest first. To follow it, ask again with `after_id` of the last one had. Role: spectator.
   */
  getTimeline(options: { since?: number | null; until?: number | null; kinds?: string | null; afterId?: number; limit?: number } = {}): Promise<EventList> {
    return this.ask<EventList>({ method: "GET", path: `/timeline`, answer: "json", query: { "since": options.since, "until": options.until, "kinds": options.kinds, "after_id": options.afterId, "limit": options.limit } });
  }

  /** One tour. Role: spectator. */
  getTour(tourId: string): Promise<TourReport> {
    return this.ask<TourReport>({ method: "GET", path: `/tours/${encodeURIComponent(tourId)}`, answer: "json" });
  }

  /** A picture or a video. Whole, or in part (`Range`). Role: spectator. */
  getTourMedia(file: string): Promise<ArrayBuffer> {
    return this.ask<ArrayBuffer>({ method: "GET", path: `/tour-media/${encodeURIComponent(file)}`, answer: "bytes" });
  }

  /** Print posters. Of the stops that have the text of a `poster`. Role: spectator. */
  getTourPosters(tourId: string, options: { paper?: "a4" | "letter"; language?: string | null; stop?: string | null } = {}): Promise<ArrayBuffer> {
    return this.ask<ArrayBuffer>({ method: "GET", path: `/tours/${encodeURIComponent(tourId)}/posters.pdf`, answer: "bytes", query: { "paper": options.paper, "language": options.language, "stop": options.stop } });
  }

  /** One report on a tour. Role: spectator. */
  getTourReport(runId: string): Promise<RunReport> {
    return this.ask<RunReport>({ method: "GET", path: `/tour-reports/${encodeURIComponent(runId)}`, answer: "json" });
  }

  /**
   * The tour under way. How it goes, and what the run has been so far; of the last one after its end. Role: spectator.
   */
  getTourRun(): Promise<TourRunReport> {
    return this.ask<TourRunReport>({ method: "GET", path: `/tour-run`, answer: "json" });
  }

  /** The JSON Schema of a tour. Draft 2020-12. What it cannot say, `POST /tours/validate` finds. Role: spectator. */
  getTourSchema(): Promise<unknown> {
    return this.ask<unknown>({ method: "GET", path: `/tour-schema`, answer: "json" });
  }

  /**
   * The link for visitors' phones. For operators: the page for visitors with the key of this run, and its QR code. The
   * key changes with each run, and opens nothing but that page. Role: operator.
   */
  getVisitorLink(): Promise<VisitorLink> {
    return this.ask<VisitorLink>({ method: "GET", path: `/tour-run/visitors`, answer: "json" });
  }

  /**
   * A picture or a video of the tour. Only what the tour under way names, out of the folder of tours; also in part
   * (`Range`). Role: spectator.
   */
  getVisitorMedia(file: string): Promise<ArrayBuffer> {
    return this.ask<ArrayBuffer>({ method: "GET", path: `/visitor/media/${encodeURIComponent(file)}`, answer: "bytes" });
  }

  /** One webhook. Role: supervisor. */
  getWebhook(webhookId: string): Promise<WebhookReport> {
    return this.ask<WebhookReport>({ method: "GET", path: `/webhooks/${encodeURIComponent(webhookId)}`, answer: "json" });
  }

  /** Zones of the map in use. Role: spectator. */
  getZones(): Promise<ZoneList> {
    return this.ask<ZoneList>({ method: "GET", path: `/map/zones`, answer: "json" });
  }

  /**
   * Import a tour's file. YAML, as `GET /tours/{tour_id}/file` gives it (or JSON, which is YAML), or the archive of
   * `GET /tours/{tour_id}/archive`, under the id in it. With `If-Match` it replaces the tour of this id (200); without,
   * that is refused. The media of an archive are kept with the tour or not at all; where another picture has a name,
   * the tour names the new one. Role: operator.
   */
  importTour(body: string | ArrayBuffer, options: { ifMatch?: string | null; media?: "application/yaml" | "application/zip" } = {}): Promise<TourReport> {
    return this.ask<TourReport>({ method: "POST", path: `/tours/import`, answer: "json", body, media: options.media ?? "application/yaml", headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Latch the emergency stop. Latches the emergency stop in the guard: the wheels are commanded to zero until it is
   * released here or on the page. Answers once the guard has confirmed it. Needs no body. May be repeated. Role:
   * spectator.
   */
  latchEStop(): Promise<EStop> {
    return this.ask<EStop>({ method: "POST", path: `/stop`, answer: "json" });
  }

  /** Channels, their freshness and counters. Role: spectator. */
  listChannels(): Promise<ChannelList> {
    return this.ask<ChannelList>({ method: "GET", path: `/channels`, answer: "json" });
  }

  /**
   * List all desire classes. Each class with the JSON Schema of its parameters: enough to build a form from. Role:
   * spectator.
   */
  listDesireClasses(): Promise<DesireClassList> {
    return this.ask<DesireClassList>({ method: "GET", path: `/desire-classes`, answer: "json" });
  }

  /**
   * List all desires. With what has become of each so far: intended, exploited, and since when (`progress`). Role:
   * spectator.
   */
  listDesires(): Promise<Desires> {
    return this.ask<Desires>({ method: "GET", path: `/desires`, answer: "json" });
  }

  /** List all maps. By name; and the one in use, which may have no name yet. Role: spectator. */
  listMaps(): Promise<MapList> {
    return this.ask<MapList>({ method: "GET", path: `/maps`, answer: "json" });
  }

  /** Modules, their load and counters. Role: spectator. */
  listModules(): Promise<ModuleList> {
    return this.ask<ModuleList>({ method: "GET", path: `/modules`, answer: "json" });
  }

  /** List all places of the map in use. In the order of their making; each with its `etag`. Role: spectator. */
  listPlaces(): Promise<PlaceList> {
    return this.ask<PlaceList>({ method: "GET", path: `/places`, answer: "json" });
  }

  /**
   * List all recordings. The newest first, with the room left on the disk and what the Recorder does. Role: spectator.
   */
  listRecordings(): Promise<RecordingList> {
    return this.ask<RecordingList>({ method: "GET", path: `/recordings`, answer: "json" });
  }

  /** Resources: budgets and use. Role: spectator. */
  listResources(): Promise<ResourceList> {
    return this.ask<ResourceList>({ method: "GET", path: `/resources`, answer: "json" });
  }

  /**
   * Rules, and when each applied last. The rules by which something is desired without code, in force now. Where a file
   * was changed and has a mistake, `problem` says which, and the rules are still those before. No rules: the program
   * has none. Role: spectator.
   */
  listRules(): Promise<RulesReport> {
    return this.ask<RulesReport>({ method: "GET", path: `/rules`, answer: "json" });
  }

  /** List all strategies. Role: spectator. */
  listStrategies(): Promise<StrategyList> {
    return this.ask<StrategyList>({ method: "GET", path: `/strategies`, answer: "json" });
  }

  /** List pictures and videos of tours. All that tours can show, by name, with the tours that do. Role: spectator. */
  listTourMedia(): Promise<TourMediaList> {
    return this.ask<TourMediaList>({ method: "GET", path: `/tour-media`, answer: "json" });
  }

  /** List reports on tours. The newest first. Of people, they have counts alone. Role: spectator. */
  listTourReports(options: { tour?: string | null } = {}): Promise<RunReportList> {
    return this.ask<RunReportList>({ method: "GET", path: `/tour-reports`, answer: "json", query: { "tour": options.tour } });
  }

  /** List all tours. By id, those that come with the program among them; each with its `etag`. Role: spectator. */
  listTours(): Promise<TourList> {
    return this.ask<TourList>({ method: "GET", path: `/tours`, answer: "json" });
  }

  /** Connected pages and 3D views, and their connections. Role: spectator. */
  listViewers(): Promise<ViewerList> {
    return this.ask<ViewerList>({ method: "GET", path: `/viewers`, answer: "json" });
  }

  /**
   * List all webhooks. In the order of their making, with how their deliveries go; without their secrets. Role:
   * supervisor.
   */
  listWebhooks(): Promise<WebhookList> {
    return this.ask<WebhookList>({ method: "GET", path: `/webhooks`, answer: "json" });
  }

  /**
   * Take a map into use. In place of the one in use, which is lost if it was not saved. Needs no body: the robot then
   * looks for itself on the map, and the map stays as it is. Every goal is withdrawn: it was a place on the other map.
   * Role: supervisor.
   */
  loadMap(name: string, body?: LoadRequest | null): Promise<CurrentMap> {
    return this.ask<CurrentMap>({ method: "POST", path: `/maps/${encodeURIComponent(name)}/load`, answer: "json", body });
  }

  /**
   * Log in. Begins a session and sets its cookie, which no script can read and no other site can use, until the browser
   * is closed. The session is over when nothing was asked in it for 12 hours, at the logout, or with the console. It
   * has the role of the password; with the token it is a supervisor's. After five wrong tokens an address waits, longer
   * with each further one. Role: any.
   */
  logIn(body: LoginRequest): Promise<Session> {
    return this.ask<Session>({ method: "POST", path: `/session`, answer: "json", body });
  }

  /** Log out. Ends this browser's session, and its WebSockets. Role: any. */
  logOut(): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/session`, answer: "nothing" });
  }

  /**
   * Set the robot's pose on the map. On the map in use, within 1 m and 0.5 rad; from there its pose is refined by what
   * the laser sees. Role: operator.
   */
  placeRobot(body: PoseRequest): Promise<CurrentMap> {
    return this.ask<CurrentMap>({ method: "PUT", path: `/map/pose`, answer: "json", body });
  }

  /**
   * Plan a route. Leg by leg, by the robot's own planner, on the map in use, its zones and what it keeps in mind of
   * obstacles; what is there for the moment does not count. Nothing moves. A leg that cannot be driven says why. Role:
   * spectator.
   */
  planRoute(body: RouteRequest): Promise<RouteReport> {
    return this.ask<RouteReport>({ method: "POST", path: `/map/route`, answer: "json", body });
  }

  /** Press as a visitor. A `button` that the tour waits for, or a question that may be asked now. Role: operator. */
  pressAsVisitor(body: VisitorPress): Promise<void> {
    return this.ask<void>({ method: "POST", path: `/visitor/press`, answer: "nothing", body });
  }

  /**
   * Steer the tour under way. A `button` (`pause`, `resume`, `skip`, `undo_skip`, `repeat`, `retry`, `end`, and the
   * visitors' `agree`, `decline`, `next`), a `stop` to go to, or a question that a visitor asks. What does nothing now
   * is refused; the answer's `buttons` are those that do. Role: operator.
   */
  pressTour(body: TourPress): Promise<TourRunReport> {
    return this.ask<TourRunReport>({ method: "POST", path: `/tour-run/press`, answer: "json", body });
  }

  /**
   * Shape the link to the pages, for tests. Delays and bounds every stream between the program and its pages from now
   * on, this answer included: live stream, 3D view, REST. `{}` ends it. Streams are ordered, so nothing is lost: a lost
   * packet is sent again, and what follows it waits. Role: supervisor.
   */
  putLink(body: LinkChange): Promise<LinkReport> {
    return this.ask<LinkReport>({ method: "PUT", path: `/link`, answer: "json", body });
  }

  /** Do again what was undone last. Needs no body. Role: operator. */
  redoTour(tourId: string, options: { ifMatch?: string | null } = {}): Promise<TourReport | undefined> {
    return this.ask<TourReport | undefined>({ method: "POST", path: `/tours/${encodeURIComponent(tourId)}/redo`, answer: "json", headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Release the emergency stop. A stop that was pressed after `seen` stays latched, so that a late release does not
   * undo a stop that its sender has not seen. The base stays still until the next fresh command. Answers once the guard
   * has confirmed it, or half a second later: a goal that is given next is not refused for a latch that is gone. An
   * operator releases what no other pressed, a supervisor any stop. Role: operator.
   */
  releaseEStop(options: { seen?: number | null } = {}): Promise<EStop> {
    return this.ask<EStop>({ method: "DELETE", path: `/stop`, answer: "json", query: { "seen": options.seen } });
  }

  /** Remove a desire. Role: operator. */
  removeDesire(desireId: string): Promise<void> {
    return this.ask<void>({ method: "DELETE", path: `/desires/${encodeURIComponent(desireId)}`, answer: "nothing" });
  }

  /**
   * Rename a map. A name that another map has is refused. The map in use is saved under its new name as it is now.
   * Role: supervisor.
   */
  renameMap(name: string, body: RenameRequest): Promise<KeptMap> {
    return this.ask<KeptMap>({ method: "PATCH", path: `/maps/${encodeURIComponent(name)}`, answer: "json", body });
  }

  /**
   * Replace a place, or create it under this id. Without a name it keeps the one that it has. With `If-Match`, nothing
   * is created. Role: operator.
   */
  replacePlace(placeId: string, body: PlaceReplacement, options: { ifMatch?: string | null } = {}): Promise<PlaceReport> {
    return this.ask<PlaceReport>({ method: "PUT", path: `/places/${encodeURIComponent(placeId)}`, answer: "json", body, headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Replace a tour, or create it under this id. The id in it may be left out. With `If-Match`, nothing is created.
   * Role: operator.
   */
  replaceTour(tourId: string, body: Record<string, unknown>, options: { ifMatch?: string | null } = {}): Promise<TourReport> {
    return this.ask<TourReport>({ method: "PUT", path: `/tours/${encodeURIComponent(tourId)}`, answer: "json", body, headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Replay a recording. Starts `hbba replay` with a console of its own and answers once that is up, within seconds. A
   * replay started here before is ended. It ends with this console, and by itself three minutes after its last viewer
   * left. Role: operator.
   */
  replayRecording(name: string): Promise<ReplayReport> {
    return this.ask<ReplayReport>({ method: "POST", path: `/recordings/${encodeURIComponent(name)}/replay`, answer: "json" });
  }

  /**
   * Keep the map in use. Under this name, which it has from then on; an older map of this name is replaced. Needs no
   * body. Role: supervisor.
   */
  saveMap(name: string): Promise<KeptMap> {
    return this.ask<KeptMap>({ method: "PUT", path: `/maps/${encodeURIComponent(name)}`, answer: "json" });
  }

  /**
   * Keep the ring's last minutes. Makes a recording of what the ring holds; the ring goes on. Needs no body. Role:
   * operator.
   */
  saveRing(body?: SaveRequest | null): Promise<Saved> {
    return this.ask<Saved>({ method: "POST", path: `/recordings/save`, answer: "json", body });
  }

  /**
   * Start global localization. It is somewhere on the map in use, and finds out where. Needs no body. Role: operator.
   */
  searchRobot(): Promise<CurrentMap> {
    return this.ask<CurrentMap>({ method: "POST", path: `/map/search`, answer: "json" });
  }

  /**
   * Send the robot somewhere. Creates a desire of class GoTo, or changes the one that was created so before: there is
   * one goal of people at a time, and a second takes the first one's place. Attention weighs it as any other; how the
   * robot does is in `navigation` of GET /goal and of the live stream. The same goal again changes nothing. A goal by
   * `place` is the pose that the place has now; one in an obstacle of the map or in a keep-out zone is refused. Role:
   * operator.
   */
  setGoal(body: GoalRequest): Promise<Desire> {
    return this.ask<Desire>({ method: "PUT", path: `/goal`, answer: "json", body });
  }

  /**
   * Draw the zones of the map in use. All of them: what is not named is gone. They are kept with the map at once if it
   * has a name. Role: operator.
   */
  setZones(body: ZonesRequest): Promise<ZoneList> {
    return this.ask<ZoneList>({ method: "PUT", path: `/map/zones`, answer: "json", body });
  }

  /**
   * Start recording. Creates a desire of class Record; attention weighs it as any other. Whether it records, and if not
   * why, is in `recorder` of the list and on the live stream. Needs no body. Refused while a recording runs that was
   * asked for here; a ring gives way, and what it held is kept as a recording of its own. Role: operator.
   */
  startRecording(body?: NewRecording | null, options: { idempotencyKey?: string | null } = {}): Promise<Desire> {
    return this.ask<Desire>({ method: "POST", path: `/recordings`, answer: "json", body, headers: { "idempotency-key": options.idempotencyKey } });
  }

  /**
   * Rehearse a tour. Plays the tour as it is kept on its map, without the robot, in a process of its own: the robot may
   * be driven meanwhile. Follow it by `GET /tour-rehearsal`. Role: operator.
   */
  startRehearsal(tourId: string, body: NewRehearsal): Promise<RehearsalReport> {
    return this.ask<RehearsalReport>({ method: "POST", path: `/tours/${encodeURIComponent(tourId)}/rehearsal`, answer: "json", body });
  }

  /**
   * Begin a tour. Now, or when visitors come. Refused while another is under way, while the robot is held, and where
   * the tour lacks something that it needs (`errors` of its `problems`). Role: operator.
   */
  startTour(tourId: string, body: NewTourRun): Promise<TourRunReport> {
    return this.ask<TourRunReport>({ method: "POST", path: `/tours/${encodeURIComponent(tourId)}/run`, answer: "json", body });
  }

  /**
   * Step to the next image. To the next image of the first camera; in a recording without images to the next scan,
   * without scans by 0.1 s. Answers once the modules have done with it. Role: operator.
   */
  stepPlayback(): Promise<PlaybackReport> {
    return this.ask<PlaybackReport>({ method: "POST", path: `/playback/step`, answer: "json" });
  }

  /**
   * Stop recording. Withdraws every desire of class Record that came over the console. Needs no body. May be repeated.
   * Role: operator.
   */
  stopRecording(): Promise<Withdrawn> {
    return this.ask<Withdrawn>({ method: "POST", path: `/recordings/stop`, answer: "json" });
  }

  /**
   * Post an event for a trial. Posts one event, whose `data.data.trial` is true, once, and answers with what became of
   * it. Role: supervisor.
   */
  tryWebhook(webhookId: string): Promise<WebhookTrial> {
    return this.ask<WebhookTrial>({ method: "POST", path: `/webhooks/${encodeURIComponent(webhookId)}/trial`, answer: "json" });
  }

  /**
   * Undo the newest change of a tour. Anyone's, since the program began: edits, deletion, import, and what a text
   * editor changed in the file. Needs no body. Role: operator.
   */
  undoTour(tourId: string, options: { toBegin?: boolean; ifMatch?: string | null } = {}): Promise<TourReport | undefined> {
    return this.ask<TourReport | undefined>({ method: "POST", path: `/tours/${encodeURIComponent(tourId)}/undo`, answer: "json", query: { "to_begin": options.toBegin }, headers: { "If-Match": options.ifMatch } });
  }

  /**
   * Check a tour. Without keeping it. Every mistake is found, with what else it lacks to run on this robot. Role:
   * spectator.
   */
  validateTour(body: Record<string, unknown>): Promise<TourVerdict> {
    return this.ask<TourVerdict>({ method: "POST", path: `/tours/validate`, answer: "json", body });
  }
}

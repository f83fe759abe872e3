/** REST of the robot; of tours and of visitors: `tourRest`, `visitorRest`. */

import { address, type Requests } from "./requests";
import type {
  CameraClick,
  CameraPoint,
  Desire,
  DesireChange,
  EventList,
  FleetReport,
  GoalRequest,
  Intention,
  LanesPast,
  LinkChange,
  LinkReport,
  LoadRequest,
  LoginRequest,
  MapList,
  NewDesire,
  NewPlace,
  NewRecording,
  Place,
  PlaceChange,
  PlaybackChange,
  PlaybackReport,
  PoseRequest,
  RecordingList,
  RenameRequest,
  ReplayReport,
  ResourceList,
  RobotEvent,
  RouteReport,
  RouteRequest,
  Saved,
  SaveRequest,
  SceneAddress,
  SceneClick,
  ScenePoint,
  StrategyList,
  StrategyReport,
  WhatIf,
  Zone,
  ZonesRequest,
} from "./types";

/** What this browser may do here. */
export interface SessionReport {
  authenticated: true;
  token_needed: boolean;
  role: "spectator" | "operator" | "supervisor";
}

export class Rest {
  constructor(private readonly requests: Requests) {}

  /** Resolves if this browser may use the console; a Problem with status 401 asks for a token. */
  async session(): Promise<SessionReport> {
    return (await this.requests.ask("GET", "/session")) as SessionReport;
  }

  /** Ends the session, here and at the robot. */
  async logOut(): Promise<void> {
    await this.requests.ask("DELETE", "/session");
  }

  async logIn(token: string): Promise<void> {
    await this.requests.ask("POST", "/session", { token } satisfies LoginRequest);
  }

  /** `kinds`, separated by commas: of those alone. `between`: two stamps. */
  async timeline(limit: number, kinds = "", between?: readonly [number, number]): Promise<RobotEvent[]> {
    const of = kinds && `&kinds=${kinds}`;
    const time = between ? `&since=${between[0]}&until=${between[1]}` : "";
    return ((await this.requests.ask("GET", `/timeline?limit=${limit}${of}${time}`)) as EventList).events;
  }

  lanes(from: number, to: number, points: number): Promise<LanesPast> {
    return this.requests.ask("GET", `/lanes?from=${from}&to=${to}&points=${points}`) as Promise<LanesPast>;
  }

  /** This robot first, then the others that it knows. */
  async fleet(): Promise<FleetReport> {
    return (await this.requests.ask("GET", "/fleet")) as FleetReport;
  }

  async strategies(): Promise<readonly StrategyReport[]> {
    return ((await this.requests.ask("GET", "/strategies")) as StrategyList).strategies;
  }

  /** A member that is null where it may not be is refused by the robot, in words. */
  async addDesire(desire: { [M in keyof NewDesire]: NewDesire[M] | null }, key: string): Promise<Desire> {
    return (await this.requests.ask("POST", "/desires", desire, { "Idempotency-Key": key })) as Desire;
  }

  async changeDesire(id: string, change: DesireChange): Promise<void> {
    await this.requests.ask("PATCH", `/desires/${encodeURIComponent(id)}`, change);
  }

  async removeDesire(id: string): Promise<void> {
    await this.requests.ask("DELETE", `/desires/${encodeURIComponent(id)}`);
  }

  /** The budget of a resource as it is set and as it was declared; null where there is no such resource. */
  async budget(name: string): Promise<{ budget: number; declared: number } | null> {
    const { resources } = (await this.requests.ask("GET", "/resources")) as ResourceList;
    return resources.find((resource) => resource.name === name) ?? null;
  }

  async changeBudget(name: string, capacity: number): Promise<void> {
    await this.requests.ask("PATCH", `/resources/${encodeURIComponent(name)}`, { capacity });
  }

  /** The intention that would follow; the robot goes on as it is. */
  async whatIf(supposed: WhatIf): Promise<Intention> {
    return (await this.requests.ask("POST", "/intention/what-if", supposed)) as Intention;
  }

  async playback(change: PlaybackChange): Promise<PlaybackReport> {
    return (await this.requests.ask("PATCH", "/playback", change)) as PlaybackReport;
  }

  async stepPlayback(): Promise<PlaybackReport> {
    return (await this.requests.ask("POST", "/playback/step")) as PlaybackReport;
  }

  /** Delays and bounds every stream to the pages, for tests; what is left out shapes nothing. */
  async shapeLink(change: LinkChange): Promise<LinkReport> {
    return (await this.requests.ask("PUT", "/link", change)) as LinkReport;
  }

  async recordings(): Promise<RecordingList> {
    return (await this.requests.ask("GET", "/recordings")) as RecordingList;
  }

  async record(options: NewRecording): Promise<void> {
    await this.requests.ask("POST", "/recordings", options);
  }

  async stopRecording(): Promise<void> {
    await this.requests.ask("POST", "/recordings/stop");
  }

  /** Keeps the ring's last minutes; resolves to the name they are kept under. */
  async saveRing(options: SaveRequest): Promise<string> {
    return ((await this.requests.ask("POST", "/recordings/save", options)) as Saved).name;
  }

  async deleteRecording(name: string): Promise<void> {
    await this.requests.ask("DELETE", `/recordings/${encodeURIComponent(name)}`);
  }

  /** Resolves to the address of the replay's own console. */
  async replay(name: string): Promise<string> {
    return ((await this.requests.ask("POST", `/recordings/${encodeURIComponent(name)}/replay`)) as ReplayReport).url;
  }

  async endReplay(name: string): Promise<void> {
    await this.requests.ask("DELETE", `/recordings/${encodeURIComponent(name)}/replay`);
  }

  recordingAddress(name: string): string {
    return address(`/recordings/${encodeURIComponent(name)}`);
  }

  async maps(): Promise<MapList> {
    return (await this.requests.ask("GET", "/maps")) as MapList;
  }

  /** Keeps the map in use under `name`. */
  async saveMap(name: string): Promise<void> {
    await this.requests.ask("PUT", mapPath(name));
  }

  /** Without a pose the robot looks for itself; `extend`: mapping goes on. */
  async loadMap(name: string, options: LoadRequest): Promise<void> {
    await this.requests.ask("POST", `${mapPath(name)}/load`, options);
  }

  async renameMap(name: string, to: string): Promise<void> {
    await this.requests.ask("PATCH", mapPath(name), { name: to } satisfies RenameRequest);
  }

  async deleteMap(name: string): Promise<void> {
    await this.requests.ask("DELETE", mapPath(name));
  }

  mapPicture(name: string, saved: number): string {
    return address(`${mapPath(name)}/picture?saved=${saved}`);
  }

  async beginMap(): Promise<void> {
    await this.requests.ask("POST", "/map/begin");
  }

  async placeRobot(pose: PoseRequest): Promise<void> {
    await this.requests.ask("PUT", "/map/pose", pose);
  }

  async searchRobot(): Promise<void> {
    await this.requests.ask("POST", "/map/search");
  }

  async markZones(zones: readonly Zone[]): Promise<void> {
    await this.requests.ask("PUT", "/map/zones", { zones: [...zones] } satisfies ZonesRequest);
  }

  async addPlace(place: NewPlace): Promise<Place> {
    return (await this.requests.ask("POST", "/places", place)) as Place;
  }

  /** Refused where another editor has changed it since. */
  async changePlace({ id, etag }: Place, change: PlaceChange): Promise<void> {
    await this.requests.ask("PATCH", placePath(id), change, { "If-Match": etag });
  }

  /** Refused where another editor has changed it since. */
  async deletePlace({ id, etag }: Place): Promise<void> {
    await this.requests.ask("DELETE", placePath(id), undefined, { "If-Match": etag });
  }

  async setGoal(goal: GoalRequest): Promise<void> {
    await this.requests.ask("PUT", "/goal", goal);
  }

  async cancelGoal(): Promise<void> {
    await this.requests.ask("DELETE", "/goal");
  }

  /** Where on the map a point of a picture is. */
  async cameraPoint(click: CameraClick): Promise<CameraPoint> {
    return (await this.requests.ask("POST", "/camera/point", click)) as CameraPoint;
  }

  /** What a point of a 3D view shows. */
  async scenePoint(click: SceneClick): Promise<ScenePoint> {
    return (await this.requests.ask("POST", "/scene/point", click)) as ScenePoint;
  }

  /** Plans and moves nothing. */
  async planRoute(wanted: RouteRequest): Promise<RouteReport> {
    return (await this.requests.ask("POST", "/map/route", wanted)) as RouteReport;
  }

  /** Where the 3D view's frame is on a port of its own. */
  async scene(): Promise<SceneAddress> {
    return (await this.requests.ask("GET", "/scene")) as SceneAddress;
  }

  /** All that is remembered, as a file. */
  memoryFile(): string {
    return address("/memory");
  }

  async deleteMemory(): Promise<void> {
    await this.requests.ask("DELETE", "/memory");
  }

  async deleteEpisode(id: number): Promise<void> {
    await this.requests.ask("DELETE", `/memory/episodes/${id}`);
  }
}

function mapPath(name: string): string {
  return `/maps/${encodeURIComponent(name)}`;
}

function placePath(id: string): string {
  return `/places/${encodeURIComponent(id)}`;
}

/** REST under `api/v1`: JSON in and out, errors as problem details (RFC 9457). */

import { t } from "../i18n";
import { sentence } from "../ui/format";
import { Problem, readProblem } from "./problem";
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
  NewRehearsal,
  NewTourRun,
  Place,
  PlaceChange,
  PlaybackChange,
  PlaybackReport,
  PoseRequest,
  RecordingList,
  RehearsalReport,
  RenameRequest,
  ReplayReport,
  ResourceList,
  RobotEvent,
  RouteReport,
  RouteRequest,
  RunReport,
  RunReportList,
  Saved,
  SaveRequest,
  SceneAddress,
  SceneClick,
  ScenePoint,
  StrategyList,
  StrategyReport,
  TourList,
  TourMedia,
  TourMediaList,
  TourPress,
  TourReport,
  TourRunReport,
  VisitorKey,
  VisitorLink,
  VisitorPress,
  WhatIf,
  Zone,
  ZonesRequest,
} from "./types";
import { upload } from "./upload";

/** What this browser may do here. */
export interface SessionReport {
  authenticated: true;
  token_needed: boolean;
  role: "spectator" | "operator" | "supervisor";
}

export { type FieldError, Problem } from "./problem";

/** A tour as the robot keeps it, and the version that a change of it is meant for. */
export interface KeptTour extends TourReport {
  etag: string;
}

export type Paper = "a4" | "letter";

const ROOT = "./api/v1";
const JSON_TYPE = "application/json";

export class Rest {
  constructor(private readonly operator: () => string) {}

  /** Resolves if this browser may use the console; a Problem with status 401 asks for a token. */
  async session(): Promise<SessionReport> {
    return (await this.ask("GET", "/session")) as SessionReport;
  }

  /** Ends the session, here and at the robot. */
  async logOut(): Promise<void> {
    await this.ask("DELETE", "/session");
  }

  async logIn(token: string): Promise<void> {
    await this.ask("POST", "/session", { token } satisfies LoginRequest);
  }

  /** `kinds`, separated by commas: of those alone. `between`: two stamps. */
  async timeline(limit: number, kinds = "", between?: readonly [number, number]): Promise<RobotEvent[]> {
    const of = kinds && `&kinds=${kinds}`;
    const time = between ? `&since=${between[0]}&until=${between[1]}` : "";
    return ((await this.ask("GET", `/timeline?limit=${limit}${of}${time}`)) as EventList).events;
  }

  lanes(from: number, to: number, points: number): Promise<LanesPast> {
    return this.ask("GET", `/lanes?from=${from}&to=${to}&points=${points}`) as Promise<LanesPast>;
  }

  /** This robot first, then the others that it knows. */
  async fleet(): Promise<FleetReport> {
    return (await this.ask("GET", "/fleet")) as FleetReport;
  }

  async strategies(): Promise<readonly StrategyReport[]> {
    return ((await this.ask("GET", "/strategies")) as StrategyList).strategies;
  }

  /** A member that is null where it may not be is refused by the robot, in words. */
  async addDesire(desire: { [M in keyof NewDesire]: NewDesire[M] | null }, key: string): Promise<Desire> {
    return (await this.ask("POST", "/desires", desire, { "Idempotency-Key": key })) as Desire;
  }

  async changeDesire(id: string, change: DesireChange): Promise<void> {
    await this.ask("PATCH", `/desires/${encodeURIComponent(id)}`, change);
  }

  async removeDesire(id: string): Promise<void> {
    await this.ask("DELETE", `/desires/${encodeURIComponent(id)}`);
  }

  /** The capacity of a resource as the configuration declares it; null: there is no such resource. */
  async declaredBudget(name: string): Promise<number | null> {
    const { resources } = (await this.ask("GET", "/resources")) as ResourceList;
    return resources.find((resource) => resource.name === name)?.declared ?? null;
  }

  async changeBudget(name: string, capacity: number): Promise<void> {
    await this.ask("PATCH", `/resources/${encodeURIComponent(name)}`, { capacity });
  }

  /** The intention that would follow; the robot goes on as it is. */
  async whatIf(supposed: WhatIf): Promise<Intention> {
    return (await this.ask("POST", "/intention/what-if", supposed)) as Intention;
  }

  async playback(change: PlaybackChange): Promise<PlaybackReport> {
    return (await this.ask("PATCH", "/playback", change)) as PlaybackReport;
  }

  async stepPlayback(): Promise<PlaybackReport> {
    return (await this.ask("POST", "/playback/step")) as PlaybackReport;
  }

  /** Delays and bounds every stream to the pages, for tests; what is left out shapes nothing. */
  async shapeLink(change: LinkChange): Promise<LinkReport> {
    return (await this.ask("PUT", "/link", change)) as LinkReport;
  }

  async recordings(): Promise<RecordingList> {
    return (await this.ask("GET", "/recordings")) as RecordingList;
  }

  async record(options: NewRecording): Promise<void> {
    await this.ask("POST", "/recordings", options);
  }

  async stopRecording(): Promise<void> {
    await this.ask("POST", "/recordings/stop");
  }

  /** Keeps the ring's last minutes; resolves to the name they are kept under. */
  async saveRing(options: SaveRequest): Promise<string> {
    return ((await this.ask("POST", "/recordings/save", options)) as Saved).name;
  }

  async deleteRecording(name: string): Promise<void> {
    await this.ask("DELETE", `/recordings/${encodeURIComponent(name)}`);
  }

  /** Resolves to the address of the replay's own console. */
  async replay(name: string): Promise<string> {
    return ((await this.ask("POST", `/recordings/${encodeURIComponent(name)}/replay`)) as ReplayReport).url;
  }

  async endReplay(name: string): Promise<void> {
    await this.ask("DELETE", `/recordings/${encodeURIComponent(name)}/replay`);
  }

  recordingAddress(name: string): string {
    return `${ROOT}/recordings/${encodeURIComponent(name)}`;
  }

  async maps(): Promise<MapList> {
    return (await this.ask("GET", "/maps")) as MapList;
  }

  /** Keeps the map in use under `name`. */
  async saveMap(name: string): Promise<void> {
    await this.ask("PUT", mapPath(name));
  }

  /** Without a pose the robot looks for itself; `extend`: mapping goes on. */
  async loadMap(name: string, options: LoadRequest): Promise<void> {
    await this.ask("POST", `${mapPath(name)}/load`, options);
  }

  async renameMap(name: string, to: string): Promise<void> {
    await this.ask("PATCH", mapPath(name), { name: to } satisfies RenameRequest);
  }

  async deleteMap(name: string): Promise<void> {
    await this.ask("DELETE", mapPath(name));
  }

  mapPicture(name: string, saved: number): string {
    return `${ROOT}${mapPath(name)}/picture?saved=${saved}`;
  }

  async beginMap(): Promise<void> {
    await this.ask("POST", "/map/begin");
  }

  async placeRobot(pose: PoseRequest): Promise<void> {
    await this.ask("PUT", "/map/pose", pose);
  }

  async searchRobot(): Promise<void> {
    await this.ask("POST", "/map/search");
  }

  async markZones(zones: readonly Zone[]): Promise<void> {
    await this.ask("PUT", "/map/zones", { zones: [...zones] } satisfies ZonesRequest);
  }

  async addPlace(place: NewPlace): Promise<Place> {
    return (await this.ask("POST", "/places", place)) as Place;
  }

  /** Refused where another editor has changed it since. */
  async changePlace({ id, etag }: Place, change: PlaceChange): Promise<void> {
    await this.ask("PATCH", placePath(id), change, { "If-Match": etag });
  }

  /** Refused where another editor has changed it since. */
  async deletePlace({ id, etag }: Place): Promise<void> {
    await this.ask("DELETE", placePath(id), undefined, { "If-Match": etag });
  }

  async setGoal(goal: GoalRequest): Promise<void> {
    await this.ask("PUT", "/goal", goal);
  }

  async cancelGoal(): Promise<void> {
    await this.ask("DELETE", "/goal");
  }

  /** Where on the map a point of a picture is. */
  async cameraPoint(click: CameraClick): Promise<CameraPoint> {
    return (await this.ask("POST", "/camera/point", click)) as CameraPoint;
  }

  /** What a point of a 3D view shows. */
  async scenePoint(click: SceneClick): Promise<ScenePoint> {
    return (await this.ask("POST", "/scene/point", click)) as ScenePoint;
  }

  /** Plans and moves nothing. */
  async planRoute(wanted: RouteRequest): Promise<RouteReport> {
    return (await this.ask("POST", "/map/route", wanted)) as RouteReport;
  }

  /** Where the 3D view's frame is on a port of its own. */
  async scene(): Promise<SceneAddress> {
    return (await this.ask("GET", "/scene")) as SceneAddress;
  }

  async tours(): Promise<TourList> {
    return (await this.ask("GET", "/tours")) as TourList;
  }

  async tour(id: string): Promise<KeptTour> {
    return (await this.askTour("GET", tourPath(id)))!;
  }

  async createTour(tour: unknown): Promise<KeptTour> {
    return (await this.askTour("POST", "/tours", tour))!;
  }

  /** Refused where another editor has changed it since `etag`. */
  async replaceTour(id: string, tour: unknown, etag: string): Promise<KeptTour> {
    return (await this.askTour("PUT", tourPath(id), tour, { "If-Match": etag }))!;
  }

  /** Null: there was no such tour before. Refused where another editor has changed it since `etag`. */
  async undoTour(id: string, etag: string, way: "undo" | "redo"): Promise<KeptTour | null> {
    return await this.askTour("POST", `${tourPath(id)}/${way}`, undefined, { "If-Match": etag });
  }

  async deleteTour(id: string, etag: string): Promise<void> {
    await this.ask("DELETE", tourPath(id), undefined, { "If-Match": etag });
  }

  /** A tour's file in YAML, or an archive with its pictures. */
  async importTour(file: Blob): Promise<KeptTour> {
    return (await this.askTour("POST", "/tours/import", file, { "Content-Type": "application/octet-stream" }))!;
  }

  /** The tour with its pictures and videos. */
  tourArchive(id: string): string {
    return `${ROOT}${tourPath(id)}/archive`;
  }

  async tourMedia(): Promise<TourMediaList> {
    return (await this.ask("GET", "/tour-media")) as TourMediaList;
  }

  async addTourMedia(file: File, onShare: (share: number) => void, signal: AbortSignal): Promise<TourMedia> {
    const url = `${ROOT}/tour-media?name=${encodeURIComponent(file.name)}`;
    const headers = { Accept: JSON_TYPE, "X-HBBA-Operator": headerSafe(this.operator()) };
    return (await upload(url, file, headers, onShare, signal)) as TourMedia;
  }

  async deleteTourMedia(file: string): Promise<void> {
    await this.ask("DELETE", `/tour-media/${parts(file)}`);
  }

  tourMediaFile(file: string): string {
    return `${ROOT}/tour-media/${parts(file)}`;
  }

  tourFile(id: string): string {
    return `${ROOT}${tourPath(id)}/file`;
  }

  /** Of the whole tour, or of one `stop`. */
  posters(id: string, paper: Paper, stop?: string): string {
    const one = stop === undefined ? "" : `&stop=${encodeURIComponent(stop)}`;
    return `${ROOT}${tourPath(id)}/posters.pdf?paper=${paper}${one}`;
  }

  async startTour(id: string, how: NewTourRun): Promise<TourRunReport> {
    return (await this.ask("POST", `${tourPath(id)}/run`, how)) as TourRunReport;
  }

  async pressTour(press: TourPress): Promise<TourRunReport> {
    return (await this.ask("POST", "/tour-run/press", press)) as TourRunReport;
  }

  /** Waits for visitors no more. */
  async dismissTour(): Promise<void> {
    await this.ask("DELETE", "/tour-run");
  }

  /** The newest first. */
  async tourReports(): Promise<RunReport[]> {
    return ((await this.ask("GET", "/tour-reports")) as RunReportList).reports;
  }

  async deleteTourReport(run: string): Promise<void> {
    await this.ask("DELETE", `/tour-reports/${encodeURIComponent(run)}`);
  }

  /** A table of all reports. */
  tourReportsTable(): string {
    return `${ROOT}/tour-reports.csv`;
  }

  /** All that is remembered, as a file. */
  memoryFile(): string {
    return `${ROOT}/memory`;
  }

  async deleteMemory(): Promise<void> {
    await this.ask("DELETE", "/memory");
  }

  async deleteEpisode(id: number): Promise<void> {
    await this.ask("DELETE", `/memory/episodes/${id}`);
  }

  /** Begins a rehearsal of a tour as it is kept; refused while another runs. */
  async rehearse(id: string, how: NewRehearsal): Promise<RehearsalReport> {
    return (await this.ask("POST", `${tourPath(id)}/rehearsal`, how)) as RehearsalReport;
  }

  async rehearsal(): Promise<RehearsalReport> {
    return (await this.ask("GET", "/tour-rehearsal")) as RehearsalReport;
  }

  async cancelRehearsal(): Promise<void> {
    await this.ask("DELETE", "/tour-rehearsal");
  }

  /** For operators: how visitors' phones get in. */
  async visitorLink(): Promise<VisitorLink> {
    return (await this.ask("GET", "/tour-run/visitors")) as VisitorLink;
  }

  /** Resolves where this browser may see the tour as a visitor. */
  async checkVisitor(): Promise<void> {
    await this.ask("GET", "/visitor/session");
  }

  async enterAsVisitor(key: string): Promise<void> {
    await this.ask("POST", "/visitor/session", { key } satisfies VisitorKey);
  }

  async pressAsVisitor(press: VisitorPress): Promise<void> {
    await this.ask("POST", "/visitor/press", press);
  }

  /** What visitors are shown; `file` as the tour names it. */
  visitorMedia(file: string): string {
    return `${ROOT}/visitor/media/${parts(file)}`;
  }

  private async askTour(
    method: string,
    path: string,
    body?: unknown,
    more: Record<string, string> = {},
  ): Promise<KeptTour | null> {
    const response = await this.answer(method, path, body, more);
    if (response.status === 204) return null;
    return { ...((await response.json()) as TourReport), etag: response.headers.get("ETag") ?? "" };
  }

  private async ask(method: string, path: string, body?: unknown, more: Record<string, string> = {}): Promise<unknown> {
    const response = await this.answer(method, path, body, more);
    return response.status === 204 ? null : await response.json().catch(() => null);
  }

  /** A file is sent as it is, all else as JSON. */
  private async answer(method: string, path: string, body: unknown, more: Record<string, string>): Promise<Response> {
    const headers: Record<string, string> = {
      Accept: JSON_TYPE,
      "X-HBBA-Operator": headerSafe(this.operator()),
      ...(body === undefined ? {} : { "Content-Type": JSON_TYPE }),
      ...more,
    };
    let response: Response;
    try {
      response = await fetch(ROOT + path, {
        method,
        headers,
        credentials: "same-origin",
        ...(body === undefined ? {} : { body: body instanceof Blob ? body : JSON.stringify(body) }),
      });
    } catch {
      throw new Problem(
        0,
        t("No answer"),
        t("The robot did not answer. Check that its program runs and that you are on its network."),
      );
    }
    if (!response.ok) throw await readProblem(response);
    return response;
  }
}

/** Of a path of files. */
function parts(file: string): string {
  return file.split("/").map(encodeURIComponent).join("/");
}

function mapPath(name: string): string {
  return `/maps/${encodeURIComponent(name)}`;
}

function tourPath(id: string): string {
  return `/tours/${encodeURIComponent(id)}`;
}

function placePath(id: string): string {
  return `/places/${encodeURIComponent(id)}`;
}

/** A refusal in one line: why, and what is wrong with each field that the reason does not name. */
export function inWords(error: unknown): string {
  if (!(error instanceof Problem)) return String(error);
  const why = error.detail || error.title;
  const fields = error.errors.map((each) => each.message).filter((message) => !why.includes(message));
  return [why, ...fields].map(sentence).join(" ");
}

/** Header values are Latin-1; a name in another script is sent percent-encoded. */
function headerSafe(name: string): string {
  return /^[\x20-\x7e]*$/.test(name) ? name : encodeURIComponent(name);
}

/** A fresh key for one intended change; `randomUUID` exists only in secure contexts. */
export function idempotencyKey(): string {
  if (typeof crypto.randomUUID === "function") return crypto.randomUUID();
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** REST of tours: their files, media and posters, the run under way, reports, rehearsals. */

import { address, parts, type Requests } from "./requests";
import type {
  NewRehearsal,
  NewTourRun,
  RehearsalReport,
  RunReport,
  RunReportList,
  TourList,
  TourMedia,
  TourMediaList,
  TourPress,
  TourReport,
  TourRunReport,
  VisitorLink,
} from "./types";

/** A tour as the robot keeps it, and the version that a change of it is meant for. */
export interface KeptTour extends TourReport {
  etag: string;
}

type Paper = "a4" | "letter";

export class TourRest {
  constructor(private readonly requests: Requests) {}

  async tours(): Promise<TourList> {
    return (await this.requests.ask("GET", "/tours")) as TourList;
  }

  async tour(id: string): Promise<KeptTour> {
    return (await this.ask("GET", tourPath(id)))!;
  }

  async createTour(tour: unknown): Promise<KeptTour> {
    return (await this.ask("POST", "/tours", tour))!;
  }

  /** Refused where another editor has changed it since `etag`. */
  async replaceTour(id: string, tour: unknown, etag: string): Promise<KeptTour> {
    return (await this.ask("PUT", tourPath(id), tour, { "If-Match": etag }))!;
  }

  /** Null: there was no such tour before. Refused where another editor has changed it since `etag`. */
  async undoTour(id: string, etag: string, way: "undo" | "redo"): Promise<KeptTour | null> {
    return await this.ask("POST", `${tourPath(id)}/${way}`, undefined, { "If-Match": etag });
  }

  async deleteTour(id: string, etag: string): Promise<void> {
    await this.requests.ask("DELETE", tourPath(id), undefined, { "If-Match": etag });
  }

  /** A tour's file in YAML, or an archive with its pictures. */
  async importTour(file: Blob): Promise<KeptTour> {
    return (await this.ask("POST", "/tours/import", file, { "Content-Type": "application/octet-stream" }))!;
  }

  /** The tour with its pictures and videos. */
  tourArchive(id: string): string {
    return address(`${tourPath(id)}/archive`);
  }

  async tourMedia(): Promise<TourMediaList> {
    return (await this.requests.ask("GET", "/tour-media")) as TourMediaList;
  }

  async addTourMedia(file: File, onShare: (share: number) => void, signal: AbortSignal): Promise<TourMedia> {
    return (await this.requests.upload(
      `/tour-media?name=${encodeURIComponent(file.name)}`,
      file,
      onShare,
      signal,
    )) as TourMedia;
  }

  async deleteTourMedia(file: string): Promise<void> {
    await this.requests.ask("DELETE", `/tour-media/${parts(file)}`);
  }

  tourMediaFile(file: string): string {
    return address(`/tour-media/${parts(file)}`);
  }

  tourFile(id: string): string {
    return address(`${tourPath(id)}/file`);
  }

  /** Of the whole tour, or of one `stop`. */
  posters(id: string, paper: Paper, stop?: string): string {
    const one = stop === undefined ? "" : `&stop=${encodeURIComponent(stop)}`;
    return address(`${tourPath(id)}/posters.pdf?paper=${paper}${one}`);
  }

  async startTour(id: string, how: NewTourRun): Promise<TourRunReport> {
    return (await this.requests.ask("POST", `${tourPath(id)}/run`, how)) as TourRunReport;
  }

  async pressTour(press: TourPress): Promise<TourRunReport> {
    return (await this.requests.ask("POST", "/tour-run/press", press)) as TourRunReport;
  }

  /** Waits for visitors no more. */
  async dismissTour(): Promise<void> {
    await this.requests.ask("DELETE", "/tour-run");
  }

  /** The newest first. */
  async tourReports(): Promise<RunReport[]> {
    return ((await this.requests.ask("GET", "/tour-reports")) as RunReportList).reports;
  }

  async deleteTourReport(run: string): Promise<void> {
    await this.requests.ask("DELETE", `/tour-reports/${encodeURIComponent(run)}`);
  }

  /** A table of all reports. */
  tourReportsTable(): string {
    return address("/tour-reports.csv");
  }

  /** Begins a rehearsal of a tour as it is kept; refused while another runs. */
  async rehearse(id: string, how: NewRehearsal): Promise<RehearsalReport> {
    return (await this.requests.ask("POST", `${tourPath(id)}/rehearsal`, how)) as RehearsalReport;
  }

  async rehearsal(): Promise<RehearsalReport> {
    return (await this.requests.ask("GET", "/tour-rehearsal")) as RehearsalReport;
  }

  async cancelRehearsal(): Promise<void> {
    await this.requests.ask("DELETE", "/tour-rehearsal");
  }

  /** For operators: how visitors' phones get in. */
  async visitorLink(): Promise<VisitorLink> {
    return (await this.requests.ask("GET", "/tour-run/visitors")) as VisitorLink;
  }

  private async ask(
    method: string,
    path: string,
    body?: unknown,
    more: Record<string, string> = {},
  ): Promise<KeptTour | null> {
    const response = await this.requests.answer(method, path, body, more);
    if (response.status === 204) return null;
    return { ...((await response.json()) as TourReport), etag: response.headers.get("ETag") ?? "" };
  }
}

function tourPath(id: string): string {
  return `/tours/${encodeURIComponent(id)}`;
}

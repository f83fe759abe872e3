/** Everything the page does with recordings: begins and ends them, reads their list, starts replays. */

import { effect, signal } from "@preact/signals";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import type { Rest } from "../protocol/rest";
import type { Recorder } from "../protocol/types";
import type { Store } from "../state/store";
import { sentence } from "../ui/format";
import { starting } from "./placeholder";
import { replayAddress } from "./recordingText";

/** A desire must be weighed and the file opened; longer than this is no matter of waiting. */
const PATIENCE_MS = 6000;
const REFRESH_MS = 10_000;

export type Pending = "start" | "stop" | "save" | null;
/** A replay that is being started, or could not be; one that runs is in the list. */
export type Replay = { state: "starting" } | { state: "failed"; text: string } | null;

export class RecordingControl {
  /** What was asked of the Recorder and has not come about yet. */
  readonly pending = signal<Pending>(null);
  /** Why the last request, or the list, failed; empty: it did not. */
  readonly problem = signal("");
  /** By the name of the recording. */
  readonly replays = signal<Readonly<Record<string, Replay>>>({});
  private timer = 0;
  private reading = false;

  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
  ) {}

  start(): void {
    let before: Recorder | null = null;
    effect(() => {
      const recorder = this.store.of("recorder").value;
      if (!recorder) return;
      if (recorder.state !== before?.state || recorder.name !== before.name) this.changed(before, recorder);
      before = recorder;
    });
    effect(() => {
      if (this.shown.value) void this.refresh();
    });
    setInterval(() => this.shown.peek() && !document.hidden && void this.refresh(), REFRESH_MS);
  }

  async record(options: { name?: string; keep_minutes?: number }): Promise<boolean> {
    return this.ask("start", () => this.rest.record(options));
  }

  async stop(): Promise<boolean> {
    return this.ask("stop", () => this.rest.stopRecording());
  }

  async save(name?: string): Promise<boolean> {
    return this.ask("save", async () => {
      const kept = await this.rest.saveRing(name ? { name } : {});
      this.store.notify("info", t("Saved as {kept}.", { kept }));
      await this.refresh();
    });
  }

  /** Resolves to why it was not deleted, or to an empty text. */
  async remove(name: string): Promise<string> {
    try {
      await this.rest.deleteRecording(name);
    } catch (error) {
      return inWords(error);
    }
    await this.refresh();
    return "";
  }

  /** Starts a replay and opens its console in a tab that is opened at once: later the browser would not let us. */
  async replay(name: string): Promise<void> {
    const tab = starting(name);
    this.say(name, { state: "starting" });
    try {
      const url = await this.rest.replay(name);
      tab?.go(this.address(url));
      await this.refresh();
      this.say(name, null);
    } catch (error) {
      this.say(name, { state: "failed", text: inWords(error) });
      tab?.close();
    }
  }

  /** Where the replay at `url` opens. */
  address(url: string): string {
    return replayAddress(url, location.href, this.store.scene.value);
  }

  async endReplay(name: string): Promise<void> {
    try {
      await this.rest.endReplay(name);
    } catch (error) {
      this.say(name, { state: "failed", text: inWords(error) });
    }
    await this.refresh();
  }

  async refresh(): Promise<void> {
    if (this.reading) return;
    this.reading = true;
    try {
      this.store.recordings.value = await this.rest.recordings();
      if (this.pending.peek() === null) this.problem.value = "";
    } catch (error) {
      this.problem.value = inWords(error);
    } finally {
      this.reading = false;
    }
  }

  private get shown() {
    return this.store.recordingsShown;
  }

  private async ask(what: NonNullable<Pending>, request: () => Promise<void>): Promise<boolean> {
    this.wait(what);
    this.problem.value = "";
    try {
      await request();
    } catch (error) {
      this.wait(null);
      this.problem.value = inWords(error);
      if (!this.shown.peek()) this.store.notify("error", this.problem.value);
      return false;
    }
    const state = this.store.of("recorder").peek()?.state;
    const done = what === "save" || (what === "start") === (state === "recording" || state === "ring");
    if (done) this.wait(null);
    return true;
  }

  private wait(what: Pending): void {
    this.pending.value = what;
    clearTimeout(this.timer);
    if (what) this.timer = setTimeout(() => this.lostPatience(), PATIENCE_MS);
  }

  private lostPatience(): void {
    const what = this.pending.peek();
    this.pending.value = null;
    if (what === "start")
      this.problem.value = t("The recording did not start. {reason}", {
        reason: sentence(this.store.of("recorder").peek()?.reason ?? ""),
      }).trim();
    else if (what === "stop")
      this.problem.value = t("Still recording: there is another desire to record. See Attention.");
    if (this.problem.peek() && !this.shown.peek()) this.store.notify("warning", this.problem.peek());
  }

  private changed(before: Recorder | null, now: Recorder): void {
    const running = now.state === "recording" || now.state === "ring";
    const pending = this.pending.peek();
    if ((pending === "start" && now.state !== "idle") || (pending === "stop" && !running)) this.wait(null);
    if (running) this.problem.value = "";
    if (before && now.state === "stopped" && before.state !== "stopped")
      this.store.notify(
        "error",
        t("Recording has stopped. {reason}", {
          reason: now.reason ? sentence(now.reason) : t("The robot does not say why."),
        }),
      );
    if (before && this.shown.peek()) void this.refresh();
  }

  private say(name: string, replay: Replay): void {
    this.replays.value = { ...this.replays.peek(), [name]: replay };
  }
}

/** Listening to the robot: its sound from the stream to this computer's loudspeaker. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { t } from "../i18n";
import { HEARD, parseSound } from "../protocol/sound";
import type { Session } from "../state/session";
import type { Store } from "../state/store";
import { sentence } from "../ui/format";
import { Playout } from "./playout";

const RATE = 48_000;
const LOOK_MS = 100;
/** The end of what was spoken is still under way to the page's ears. */
const UNMUTE_MS = 500;
/** From a cold start: a strategy is chosen, a filter opened, the first frame made. */
const PATIENCE_S = 2;

interface Player {
  context: AudioContext;
  volume: GainNode;
  playout: Playout;
}

export class Listening {
  readonly on = signal(false);
  /** The robot's time now less that of what is heard, s; null: nothing is heard. */
  readonly latency = signal<number | null>(null);
  /** Of what is heard, dB of full scale. */
  readonly level = signal<number | null>(null);
  /** Why there is nothing to listen to, in words; null: one can. */
  readonly refusal: ReadonlySignal<string | null>;
  /** Why nothing is heard though one listens. */
  readonly silence: ReadonlySignal<string | null>;
  private readonly waited = signal(false);
  private player: Player | null = null;
  private timer = 0;
  private heardAt = 0;
  private unmuting = 0;

  constructor(
    private readonly store: Store,
    private readonly session: Session,
  ) {
    this.refusal = computed(() => whyNot(store));
    this.silence = computed(() => this.whySilent());
  }

  start(): void {
    this.session.onBinary.set(HEARD, (frame) => this.take(frame));
    this.session.onHello.add(() => this.greeted());
    effect(() => {
      const phase = this.store.link.value.phase;
      if (!this.on.peek() || (phase !== "lost" && phase !== "login")) return;
      this.end();
      this.store.notify(
        "warning",
        t("The connection was lost: you no longer hear the robot. Press Listen to hear it again."),
      );
    });
  }

  /** In a click: before that, browsers play nothing. */
  toggle(): void {
    if (this.on.peek()) {
      this.session.send({ type: "listen", on: false });
      this.end();
    } else if (this.refusal.peek()) this.store.notify("warning", this.refusal.peek()!);
    else this.begin();
  }

  /** Silent while the operator speaks, or both would hear themselves a moment late. */
  mute(muted: boolean): void {
    clearTimeout(this.unmuting);
    const set = () => this.player?.volume.gain.setTargetAtTime(muted ? 0 : 1, this.player.context.currentTime, 0.01);
    if (muted) set();
    else this.unmuting = window.setTimeout(set, UNMUTE_MS);
  }

  private begin(): void {
    let context: AudioContext;
    try {
      context = new AudioContext({ sampleRate: RATE, latencyHint: "interactive" });
    } catch {
      this.store.notify("error", t("This browser cannot play the robot's sound."));
      return;
    }
    const volume = new GainNode(context);
    volume.connect(context.destination);
    void context.resume();
    this.player = { context, volume, playout: new Playout(context.sampleRate) };
    this.on.value = true;
    this.heardAt = performance.now();
    this.timer = window.setInterval(() => this.look(), LOOK_MS);
    this.session.send({ type: "listen", on: true });
  }

  private end(): void {
    clearInterval(this.timer);
    void this.player?.context.close();
    this.player = null;
    this.on.value = false;
    this.latency.value = this.level.value = null;
    this.waited.value = false;
  }

  /** A new connection knows nothing of what the old one was asked for. */
  private greeted(): void {
    if (!this.player) return;
    if (this.refusal.peek()) {
      this.end();
      return;
    }
    this.player.playout = new Playout(this.player.context.sampleRate);
    this.session.send({ type: "listen", on: true });
  }

  private take(frame: ArrayBuffer): void {
    const sound = parseSound(frame);
    if (!sound || !this.player) return;
    const { context, volume, playout } = this.player;
    if (context.state !== "running") return;
    const piece = playout.push(sound, context.currentTime);
    if (!piece || piece.samples.length === 0) return;
    const buffer = new AudioBuffer({ length: piece.samples.length, sampleRate: context.sampleRate });
    buffer.copyToChannel(piece.samples, 0);
    const source = new AudioBufferSourceNode(context, { buffer });
    source.connect(volume);
    source.start(piece.at);
  }

  private look(): void {
    if (!this.player) return;
    const { context, playout } = this.player;
    const heard = playout.heard(context.currentTime - (context.outputLatency || context.baseLatency || 0));
    const at = performance.now();
    const now = this.store.clock.now(at / 1000);
    if (heard) this.heardAt = at;
    this.latency.value = heard && now !== null ? Math.max(0, now - heard.stamp) : null;
    this.level.value = heard?.level ?? null;
    this.waited.value = at - this.heardAt > PATIENCE_S * 1000;
  }

  private whySilent(): string | null {
    if (!this.on.value || !this.waited.value) return null;
    const { store } = this;
    if (store.replay.value)
      return store.playback.value?.playing ? t("No sound was recorded here.") : t("The recording is paused.");
    const lane = store.rows.value.find((row) => row.class === "Listen");
    if (lane && lane.divisor === null && lane.state !== "undesired") return sentence(lane.text);
    if (this.player && this.player.context.state !== "running") return t("The browser blocks the sound.");
    return t("No sound comes from the robot.");
  }
}

function whyNot(store: Store): string | null {
  const phase = store.link.value.phase;
  const hello = store.hello.value;
  if (!hello || (phase !== "live" && phase !== "stale")) return t("Not connected to the robot.");
  if (!hello.audio.listen)
    return store.replay.value
      ? t("This recording has no sound.")
      : t("This robot has no microphones to listen through.");
  const lane = store.rows.value.find((row) => row.class === "Listen");
  if (lane?.state === "inhibited" && !store.replay.value)
    return t("Listening is forbidden now: {text}", { text: lane.text });
  return null;
}

/** Joins the browser's inputs (keys, stick, gamepads, focus) to the state machine, and its commands to the socket. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { fromRobot, t } from "../i18n";
import type { PlaybackController } from "../playback/playbackController";
import type { Session } from "../state/session";
import type { Store } from "../state/store";
import type { Axes, HeadAxes } from "./axes";
import { DoublePress } from "./doublePress";
import { handsOf, pass, restyled, STYLES, type Style } from "./driveStyle";
import { type PadReading, readPads } from "./gamepad";
import { DRIVE_KEYS, HEAD_KEYS, OVERRIDE_KEYS, SLOW_KEYS, STRAFE_KEYS } from "./keys";
import { type Command, type DriveState, flush, holds, type Input, initialDrive, step, TICK_MS } from "./machine";
import { keepMapping, mappingOf, type PadMapping } from "./padMapping";

export const PRESETS = [
  { name: "Slow", factor: 0.35 },
  { name: "Normal", factor: 0.65 },
  { name: "Full", factor: 1 },
] as const;
/** A tick may come this much early, or the next chance would make it late. */
const EARLY_MS = 5;
const PRESET_KEY = "hbba.preset";
const STYLE_KEY = "hbba.driveStyle";

/** Where the keyboard is when it cannot drive. */
export type KeyboardPlace = "page" | "field" | "away";

export class DriveController {
  readonly state = signal<DriveState>(initialDrive(readPreset()));
  /** Whether a hand on this page holds the base or the head. */
  readonly holding = computed(() => holds(this.state.value.command));
  readonly keyboard = signal<KeyboardPlace>("page");
  /** How keys and stick on screen drive: held, by steps, or by presses. */
  readonly style = signal<Style>(readStyle());
  private hands = handsOf(this.style.peek());
  /** The stick on screen, pushed sideways, moves a body sideways that can; else it turns. */
  readonly stickStrafes = signal(false);
  /** Why driving is refused now, in words; null: it is not. */
  readonly refusal: ReadonlySignal<string | null>;
  private chosenPad: PadReading["chosen"] = null;
  private padStop = false;
  private padHome = false;
  /** What a gamepad's button for it does: send the robot back to the start. */
  onHome: () => void = () => {};
  /** Ends every trip that the robot makes by itself; whether there was any. */
  onStop: () => boolean = () => false;
  /** Called with each command that went to the socket. */
  onSent: (command: Command) => void = () => {};
  /** Space is down and has stopped something: it is no press of a button. */
  private stopping = false;
  private readonly twice = new DoublePress();
  private polling = false;
  /** Read once: pads are polled at each frame. */
  private readonly mappings = new Map<string, PadMapping>();
  private beatAt = 0;

  constructor(
    private readonly store: Store,
    private readonly session: Session,
    private readonly playback: PlaybackController,
  ) {
    this.refusal = computed(() => whyNot(store));
  }

  start(): void {
    effect(() => this.input({ type: "allow", allowed: this.refusal.value === null }));
    window.setInterval(() => this.beat(), TICK_MS);
    this.session.onChance = () => this.beat();
    this.listenTo(window);
    window.addEventListener("blur", () => this.release());
    window.addEventListener("pagehide", () => this.release(true));
    document.addEventListener("visibilitychange", () => this.release(document.hidden));
    document.addEventListener("focusin", (event) => {
      if (typesText(event.target)) this.release();
    });
    for (const kind of ["focusin", "focusout"]) document.addEventListener(kind, () => this.look());
    for (const kind of ["focus", "blur"]) window.addEventListener(kind, () => this.look());
    window.addEventListener("gamepadconnected", () => this.poll());
    window.addEventListener("gamepaddisconnected", () => this.release());
  }

  input(input: Input): void {
    const { hands, inputs } = pass(this.hands, input);
    this.hands = hands;
    for (const each of inputs) this.feed(each);
  }

  /** Drives in another style from now on. */
  choose(style: Style): void {
    localStorage.setItem(STYLE_KEY, style);
    const { hands, inputs } = restyled(this.hands, style);
    this.hands = hands;
    this.style.value = style;
    for (const each of inputs) this.feed(each);
  }

  /** The pads plugged in and used since the page was opened. */
  pads(): Gamepad[] {
    return navigator.getGamepads().filter((pad) => pad !== null);
  }

  mapping(id: string): PadMapping {
    return mappingOf(id, localStorage);
  }

  /** Keeps what the pad `id` does; whatever it holds is let go of. */
  map(id: string, mapping: PadMapping): void {
    this.release();
    keepMapping(id, mapping, localStorage);
    this.mappings.delete(id);
  }

  private feed(input: Input): void {
    const { state, send } = step(this.state.peek(), input);
    if (state !== this.state.peek()) this.state.value = state;
    for (const command of send) this.send(command);
  }

  /** Lets go of everything; `now`: without waiting for the next ticks to repeat it. */
  release(now = false): void {
    this.input({ type: "release" });
    if (!now) return;
    const { state, send } = flush(this.state.peek());
    this.state.value = state;
    for (const command of send) this.send(command);
  }

  private send(command: Command): void {
    if (this.session.send({ type: "drive", ...command })) this.onSent(command);
  }

  /** The tick of the held command: not more often than it is wanted, however many chances there are. */
  private beat(): void {
    const now = performance.now();
    if (now - this.beatAt < TICK_MS - EARLY_MS) return;
    this.beatAt = now;
    this.input({ type: "tick" });
  }

  grasp(axes: Axes): void {
    if (this.refusal.peek()) this.explain();
    else this.input({ type: "stick-start", axes });
  }

  graspHead(axes: HeadAxes): void {
    if (this.refusal.peek()) this.explain();
    else this.input({ type: "head-start", axes });
  }

  /** Turns the head to `u`, `v` (shares of its width and height) of the camera's picture taken at `stamp`. */
  lookHere(stamp: number, u: number, v: number): void {
    if (this.refusal.peek()) this.explain();
    else this.session.send({ type: "look", stamp, u, v });
  }

  preset(factor: number): void {
    localStorage.setItem(PRESET_KEY, String(factor));
    this.input({ type: "preset", factor });
  }

  /** Takes the keys pressed on `target`, and on what is in it. */
  listenTo(target: Window): void {
    target.addEventListener("keydown", (event) => this.keyDown(event), { capture: true });
    target.addEventListener("keyup", (event) => this.keyUp(event), { capture: true });
  }

  private keyDown(event: KeyboardEvent): void {
    if (this.store.replay.peek()) {
      this.replayKeyDown(event);
      return;
    }
    if (event.code === "Escape" && !event.repeat) {
      // What opens over a page closes with Escape everywhere: that must not leave a standing robot latched.
      const stands = this.store.stands.peek() && !this.state.peek().command.held;
      const isOpen = this.store.help.peek() || this.store.popups.length > 0;
      const onlyClose = isOpen && stands && !this.onStop();
      this.release();
      this.store.help.value = false;
      this.store.closeNewest();
      if (!onlyClose) this.session.eStop();
      return;
    }
    if (event.ctrlKey || event.altKey || event.metaKey) {
      this.release(); // the browser may swallow the key's release
      return;
    }
    if (typesText(event.target)) return;
    if (event.code === "Space") this.space(event);
    else if (event.key === "?") this.store.help.value = !this.store.help.value;
    else if (!this.store.body.peek().drives) return;
    else if (this.moves(event)) {
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat && this.refusal.peek()) this.explain();
      this.input({ type: "key", code: event.code, down: true, repeat: event.repeat });
    } else if (SLOW_KEYS.has(event.code) || OVERRIDE_KEYS.has(event.code))
      this.input({ type: "key", code: event.code, down: true, repeat: event.repeat });
  }

  /** Whether the key moves the base or the head of this body. */
  private moves({ code, target }: KeyboardEvent): boolean {
    if (HEAD_KEYS.has(code)) return this.store.body.peek().turnsHead;
    if (STRAFE_KEYS.has(code)) return this.store.body.peek().strafes;
    return DRIVE_KEYS.has(code) && !(code.startsWith("Arrow") && ownsArrows(target));
  }

  /** Twice: the emergency stop. Once: stops all driving, teleoperation and goal. While anything does, it presses no button, or "To start" might go on. */
  private space(event: KeyboardEvent): void {
    if (!event.repeat && this.twice.press(event.timeStamp)) {
      this.release(true);
      this.session.eStop();
      this.stopping = true;
    } else if (!event.repeat) {
      const held = holds(this.state.peek().command);
      this.release();
      this.stopping = this.onStop() || held;
    }
    if (this.stopping) event.stopPropagation();
    if (this.stopping || !isControl(event.target)) event.preventDefault();
  }

  /** Keys of a recording: nothing in it can be driven or stopped. */
  private replayKeyDown(event: KeyboardEvent): void {
    if (event.code === "Escape") {
      this.store.help.value = false;
      this.store.closeNewest();
    } else if (event.ctrlKey || event.altKey || event.metaKey) return;
    else if (event.key === "?" && !typesText(event.target)) this.store.help.value = !this.store.help.value;
    else {
      const onTimeline = !!closest(event.target, "[data-playback-keys]");
      const taken = this.playback.key({
        code: event.code,
        typing: typesText(event.target),
        ownsArrows: !onTimeline && ownsArrows(event.target),
        pressable: !onTimeline && isControl(event.target),
      });
      if (!taken) return;
      event.preventDefault();
      event.stopPropagation();
    }
  }

  private keyUp(event: KeyboardEvent): void {
    if (event.code === "Space" && this.stopping) {
      this.stopping = false;
      event.preventDefault();
      event.stopPropagation();
    }
    this.input({ type: "key", code: event.code, down: false });
  }

  private explain(): void {
    const reason = this.refusal.peek();
    // While nothing is heard, the banner over the view says it already.
    if (reason && this.store.live.peek()) this.store.notify("warning", reason);
  }

  /** Finds out where the keyboard is, once the browser has moved it. */
  private look(): void {
    queueMicrotask(() => {
      const active = document.activeElement;
      if (!document.hasFocus()) this.keyboard.value = "away";
      else this.keyboard.value = typesText(active) ? "field" : "page";
    });
  }

  private known(id: string): PadMapping {
    let found = this.mappings.get(id);
    if (!found) {
      found = mappingOf(id, localStorage);
      this.mappings.set(id, found);
    }
    return found;
  }

  private poll(): void {
    if (this.polling) return;
    this.polling = true;
    const frame = () => {
      const pads = navigator.getGamepads();
      const { chosen, axes, override, stop, home } = readPads(
        pads,
        this.chosenPad,
        this.store.body.peek().strafes,
        (id) => this.known(id),
      );
      if (this.chosenPad && !chosen) this.release();
      this.chosenPad = chosen;
      this.input({ type: "pad", axes: document.hasFocus() ? axes : null, override });
      if (stop && !this.padStop && !this.store.replay.peek()) this.session.eStop();
      this.padStop = stop;
      if (home && !this.padHome && document.hasFocus() && !this.store.replay.peek()) this.onHome();
      this.padHome = home;
      this.polling = pads.some((pad) => pad !== null);
      if (this.polling) requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }
}

function whyNot(store: Store): string | null {
  const phase = store.link.value.phase;
  if (store.replay.value) return t("This is a recording: it cannot be driven.");
  if (!store.body.value.drives) return t("This robot cannot be driven.");
  if (phase === "stale") return t("The page's data is old. You can drive when the robot answers again.");
  if (phase !== "live") return t("Not connected to the robot.");
  const status = store.of("status").value;
  if (store.role.value === "spectator")
    return t("You are logged in as a spectator: you see everything, and can stop the robot, but not drive it.");
  if (status?.guard.e_stopped) return t("The emergency stop is latched. Release it to drive.");
  if (status?.guard.state === "silent") return fromRobot(status.guard.reason);
  if (status?.waits) return fromRobot(status.waits);
  if (status?.driver && !status.driver.mine)
    return t("{operator} is driving. Ask for the wheel to drive yourself.", { operator: status.driver.operator });
  return null;
}

function readStyle(): Style {
  return STYLES.find((each) => each === localStorage.getItem(STYLE_KEY)) ?? "hold";
}

function readPreset(): number {
  const kept = Number(localStorage.getItem(PRESET_KEY));
  return PRESETS.find(({ factor }) => factor === kept)?.factor ?? PRESETS[1].factor;
}

function closest(target: EventTarget | Element | null, selector: string): Element | null {
  const element = target as Element | null;
  return element && typeof element.closest === "function" ? element.closest(selector) : null;
}

export function typesText(target: EventTarget | Element | null): boolean {
  const field = closest(target, "input, textarea, select, [contenteditable=''], [contenteditable='true']");
  const type = (field as HTMLInputElement | null)?.type;
  return !!field && !(type === "range" || type === "checkbox" || type === "radio" || type === "button");
}

function ownsArrows(target: EventTarget | null): boolean {
  return !!closest(target, "input, [data-own-arrows]");
}

function isControl(target: EventTarget | null): boolean {
  return !!closest(target, "button, a, input, summary, [role=button], [role=tab]");
}

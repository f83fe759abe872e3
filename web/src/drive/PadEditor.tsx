/** What each stick and button of a gamepad does: assigned by moving or pressing it, kept for this kind of pad. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { checked, movedAxis, type PadMapping, pressedButton, STANDARD } from "./padMapping";

const LOOK_MS = 50;
const AXES = { forward: "Forward", turn: "Turn", lateral: "Sideways" } as const;
const BUTTONS = { deadMan: "Held to drive", override: "Crawl on", stop: "Emergency stop", home: "To start" } as const;
type AxisName = keyof typeof AXES;
type ButtonName = keyof typeof BUTTONS;

export function PadEditor() {
  const { drive, store } = useApp();
  const pad = useSignal<{ id: string; index: number } | null>(null);
  const mapping = useSignal<PadMapping>(STANDARD);
  /** What the next stick or button is for, and how the pad was when that was asked. */
  const asked = useSignal<{ name: AxisName | ButtonName; axes: number[]; buttons: boolean[] } | null>(null);
  const problem = useSignal("");

  useEffect(() => {
    const look = () => {
      const found = drive.pads()[0] ?? null;
      if (found?.id !== pad.peek()?.id) {
        pad.value = found && { id: found.id, index: found.index };
        if (found) mapping.value = drive.mapping(found.id);
        asked.value = null;
      }
      if (found) listen(found);
    };
    look();
    const timer = setInterval(look, LOOK_MS);
    return () => clearInterval(timer);
  }, []);

  if (!pad.value) return <p class="muted small">{t("Press a button of a gamepad to change what it does.")}</p>;
  const { id } = pad.value;
  const { strafes } = store.body.value;
  return (
    <fieldset class="pad-editor" data-testid="pad-editor">
      <legend title={id}>{id.replace(/ \(.*/, "")}</legend>
      {(Object.keys(AXES) as AxisName[])
        .filter((name) => name !== "lateral" || strafes)
        .map((name) => axisLine(name, ([] as number[]).concat(mapping.value[name])))}
      {(Object.keys(BUTTONS) as ButtonName[]).map((name) => {
        const buttons = ([] as number[]).concat(mapping.value[name]);
        return line(name, t(BUTTONS[name]), buttons.map((button) => t("button {button}", { button })).join(", "));
      })}
      {slide("deadband", t("Deadband"), 0.5)}
      {slide("expo", t("Gentle middle"), 1)}
      {problem.value && (
        <p class="inline-note error" role="alert">
          {problem.value}
        </p>
      )}
      <button type="button" class="button small" onClick={() => put(STANDARD)}>
        {t("Standard mapping")}
      </button>
    </fieldset>
  );

  function axisLine(name: AxisName, axes: number[]) {
    const inverted = (
      <label class="small">
        <input
          type="checkbox"
          checked={axes.every((axis) => mapping.value.inverted.includes(axis))}
          onChange={(event) => invert(axes, event.currentTarget.checked)}
        />
        {t("inverted")}
      </label>
    );
    return line(name, t(AXES[name]), axes.map((axis) => t("axis {axis}", { axis })).join(", "), inverted);
  }

  function line(name: AxisName | ButtonName, title: string, is: string, more: ComponentChildren = null) {
    const waits = asked.value?.name === name;
    return (
      <div class="pad-line" key={name}>
        <span>{title}</span>
        <button
          type="button"
          class={`button small ${waits ? "accent" : ""}`}
          data-testid={`pad-${name}`}
          aria-label={t("{title}: {is}. Change", { title, is })}
          onClick={() => ask(name)}
        >
          {waits ? (name in AXES ? t("Push it…") : t("Press it…")) : is}
        </button>
        {more}
      </div>
    );
  }

  function slide(name: "deadband" | "expo", title: string, most: number) {
    return (
      <label class="pad-line" key={name}>
        <span>{title}</span>
        <input
          type="range"
          min={0}
          max={most}
          step={0.02}
          value={mapping.value[name]}
          onInput={(event) => put({ ...mapping.value, [name]: Number(event.currentTarget.value) })}
        />
      </label>
    );
  }

  function ask(name: AxisName | ButtonName): void {
    const found = drive.pads()[0];
    problem.value = "";
    asked.value = found ? { name, axes: [...found.axes], buttons: found.buttons.map((b) => b.pressed) } : null;
  }

  function listen(found: Gamepad): void {
    const wanted = asked.peek();
    if (!wanted) return;
    const buttons = found.buttons.map((button) => button.pressed);
    const axial = wanted.name in AXES;
    const at = axial ? movedAxis(wanted.axes, found.axes) : pressedButton(wanted.buttons, buttons);
    if (at === null) {
      asked.value = { ...wanted, buttons }; // a button that was held counts once it is pressed again
      return;
    }
    asked.value = null;
    const several = Array.isArray(mapping.peek()[wanted.name]);
    put({ ...mapping.peek(), [wanted.name]: several ? [at] : at });
  }

  function invert(axes: readonly number[], on: boolean): void {
    const others = mapping.peek().inverted.filter((axis) => !axes.includes(axis));
    put({ ...mapping.peek(), inverted: on ? [...others, ...axes] : others });
  }

  function put(next: PadMapping): void {
    if (!pad.peek()) return;
    if (!checked(next)) {
      problem.value = t("The buttons that are held to drive can do nothing else.");
      return;
    }
    problem.value = "";
    mapping.value = next;
    drive.map(pad.peek()!.id, next);
  }
}

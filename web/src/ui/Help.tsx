/** The shortcuts sheet. */

import { useEffect, useRef } from "preact/hooks";
import { named, type Text, t } from "../i18n";
import { LanguageChoice } from "../i18n/LanguageChoice";
import { useApp } from "../state/context";
import { CloseIcon } from "./icons";

type Rows = [string[], Text][];

const DRIVE: Rows = [
  [["W", "A", "S", "D"], "Hold to drive; the arrow keys work too"],
  [["Q", "E"], "Hold: move sideways, where the robot can"],
  [["Shift"], "Hold: drive slowly"],
  [["O"], "Hold while driving: crawl without the collision monitor. It does not stop for obstacles: watch it"],
  [["Space"], "Stop driving and cancel the goal. Then release all keys and press again to drive"],
];
const HEAD: Rows = [[["I", "J", "K", "L"], "Hold to turn the head; a click on the camera's picture turns it there"]];
const STOP: Rows = [
  [
    ["Esc"],
    "Emergency stop, from anywhere on the page; Space twice does the same. It cancels the goal and stays latched until released. If the robot is idle and has no goal, Esc first closes this sheet or cancels the map tool",
  ],
];
const STOP_ALONE: Rows = [
  [
    ["Esc"],
    "Emergency stop, from anywhere on the page. It stays latched until released. If this sheet is open, Esc first closes it",
  ],
];
const SPEAK: Rows = [[["V"], "Hold to speak through the robot"]];
const VIEW: Rows = [
  [["1", "7"], "1 to 7: from where the 3D view looks; its buttons say which. Drag to orbit, wheel to zoom"],
];
const SHEET: Rows = [[["?"], "This sheet"]];
const PAD: Rows = [
  [["L1", "R1"], "Hold one of them to drive (the dead-man)"],
  [["Left stick"], "Forward, backward, turn; the right stick turns too"],
  [["L2", "R2"], "Hold while driving: crawl without the collision monitor"],
];
const PAD_HOME: Rows = [[["Y", "△"], "Return to the start of the map"]];
const PAD_STOP: Rows = [[["B", "○"], "Emergency stop"]];
const RECORDING: Rows = [
  [["Space"], "Play and pause"],
  [[",", "."], "Step back and forward"],
  [["←", "→"], "Five seconds back and forward"],
  [["Home", "End"], "To the beginning, to the end"],
  [["?"], "This sheet; Esc closes it"],
];
const MAP: Rows = [
  [["M"], "Map over the whole view, and back"],
  [
    ["G"],
    "With the map in focus: the Go to tool. Press on the goal and drag to set the heading, or use the keys below",
  ],
  [["↑ ↓", "← →"], "With the map in focus: move the cursor (Shift: faster)"],
  [["Enter"], "Set a goal at the cursor: arrows turn it, Enter sends it. With a zone tool: set a corner"],
  [["+", "−", "⌫"], "Zoom; cancel the goal or remove the last corner"],
];
const LANES: Rows = [
  [["← →", "↑ ↓"], "With the lanes in focus: move the cursor that shows values and reasons"],
  [["+", "−", "P"], "Zoom, pause; also by wheel, pinch and drag"],
  [["Enter"], "Pin the instant: its whole intention and the reasons; also by a click"],
  [["T"], "Lanes over the whole window, and back"],
];

export function Help() {
  const { store } = useApp();
  const close = useRef<HTMLButtonElement>(null);
  const open = store.help.value;
  const replay = store.replay.value;
  const { drives, turnsHead, maps, goes } = store.body.value;
  const stop = drives || goes || maps ? STOP : STOP_ALONE;
  const speak = store.hello.value?.audio.speak === false ? [] : SPEAK;
  const keys = [...(drives ? DRIVE : []), ...(turnsHead ? HEAD : []), ...stop, ...speak, ...VIEW, ...SHEET];
  const faced = store.hello.value?.classes.some((each) => each.name === "Express");
  useEffect(() => {
    if (open) close.current?.focus();
  }, [open]);
  if (!open) return null;
  return (
    <div class="sheet" role="dialog" aria-label={t("Shortcuts")} data-testid="help-sheet">
      <div class="sheet-head">
        <h2>{t("Controls")}</h2>
        <button
          type="button"
          ref={close}
          class="icon-button"
          aria-label={t("Close")}
          onClick={() => (store.help.value = false)}
        >
          <CloseIcon />
        </button>
      </div>
      <LanguageChoice />
      <Keys title={t("Keyboard")} keys={replay ? RECORDING : keys} />
      {!replay && (
        <Keys title={t("Gamepad")} keys={[...(drives ? PAD : []), ...(maps && goes ? PAD_HOME : []), ...PAD_STOP]} />
      )}
      {maps && <Keys title={t("Map")} keys={replay ? MAP.slice(0, 1) : MAP} />}
      <Keys title={t("Lanes")} keys={LANES} />
      {!replay && drives && (
        <p class="muted small">
          {t(
            "Letting go ends your driving; so do another window, a hidden tab, a lost pointer, an unplugged gamepad and a cut link. To a goal the robot goes by itself, until Space, Cancel or the emergency stop ends that. Keys typed in a field never drive.",
          )}
        </p>
      )}
      {faced && (
        <p class="small">
          <a href="./face" target="_blank" rel="noopener" data-testid="face-link">
            {t("The robot’s face")}
          </a>
          {t(", on a page of its own for a full screen")}
        </p>
      )}
    </div>
  );
}

function Keys({ title, keys }: { title: string; keys: Rows }) {
  return (
    <section>
      <h3>{title}</h3>
      <dl>
        {keys.map(([names, words]) => (
          <div key={words}>
            <dt>
              {names.map((name) => (
                <kbd key={name}>{named(name)}</kbd>
              ))}
            </dt>
            <dd>{t(words)}</dd>
          </div>
        ))}
      </dl>
    </section>
  );
}

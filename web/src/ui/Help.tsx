/** The shortcuts sheet. */

import { useEffect, useRef } from "preact/hooks";
import { useApp } from "../state/context";
import { CloseIcon } from "./icons";

type Rows = [string[], string][];

const DRIVE: Rows = [
  [["W", "A", "S", "D"], "Drive while held; so do the arrow keys"],
  [["Shift"], "Held: slowly"],
  [["O"], "Held while driving: crawl, whatever stands in the way. Only your eyes stop the robot then"],
  [["Space"], "Stop: lets go of the wheel, and cancels the goal. What was held must be pressed anew"],
];
const STOP: Rows = [
  [
    ["Esc"],
    "Emergency stop, from anywhere on the page; it withdraws the goal, too, and stays latched until it is released. While the robot stands without a goal, it closes this sheet or gives up what is begun on the map instead",
  ],
];
const STOP_ALONE: Rows = [
  [
    ["Esc"],
    "Emergency stop, from anywhere on the page; it stays latched until it is released. While this sheet is open, it closes that instead",
  ],
];
const SPEAK: Rows = [[["V"], "Speak through the robot while held"]];
const SHEET: Rows = [[["?"], "This sheet"]];
const PAD: Rows = [
  [["L1", "R1"], "Hold one of them to drive (the dead-man)"],
  [["Left stick"], "Forward, backward, turn; the right stick turns too"],
  [["L2", "R2"], "Held while driving: crawl, whatever stands in the way"],
];
const PAD_HOME: Rows = [[["Y", "△"], "Return to where the map began"]];
const PAD_STOP: Rows = [[["B", "○"], "Emergency stop"]];
const RECORDING: Rows = [
  [["Space"], "Play and pause"],
  [[",", "."], "Step back and forward"],
  [["←", "→"], "Five seconds back and forward"],
  [["Home", "End"], "To the beginning, to the end"],
  [["?"], "This sheet; Esc closes it"],
];
const MAP: Rows = [
  [["M"], "The map over all of the view, and back"],
  [["G"], "Go to, with the map in focus: press on the place and drag to where it should look, or use the keys below"],
  [["↑ ↓", "← →"], "With the map in focus: move the cursor, with Shift further"],
  [["Enter"], "A goal there: arrows turn it, Enter sends it; a zone's corner with its tool"],
  [["+", "−", "⌫"], "Zoom; take back the goal or the last corner"],
];
const LANES: Rows = [
  [["← →", "↑ ↓"], "With the lanes in focus: move the cursor that tells why"],
  [["+", "−", "P"], "Zoom, pause. Wheel, pinch and drag do the same"],
];

export function Help() {
  const { store } = useApp();
  const close = useRef<HTMLButtonElement>(null);
  const open = store.help.value;
  const replay = store.replay.value;
  const { drives, maps, goes } = store.body.value;
  const stop = drives || goes || maps ? STOP : STOP_ALONE;
  const speak = store.hello.value?.audio.speak === false ? [] : SPEAK;
  const keys = [...(drives ? DRIVE : []), ...stop, ...speak, ...SHEET];
  useEffect(() => {
    if (open) close.current?.focus();
  }, [open]);
  if (!open) return null;
  return (
    <div class="sheet" role="dialog" aria-label="Shortcuts" data-testid="help-sheet">
      <div class="sheet-head">
        <h2>{replay ? "Hands on the recording" : "Hands on the robot"}</h2>
        <button
          type="button"
          ref={close}
          class="icon-button"
          aria-label="Close"
          onClick={() => (store.help.value = false)}
        >
          <CloseIcon />
        </button>
      </div>
      <Keys title="Keyboard" keys={replay ? RECORDING : keys} />
      {!replay && (
        <Keys title="Gamepad" keys={[...(drives ? PAD : []), ...(maps && goes ? PAD_HOME : []), ...PAD_STOP]} />
      )}
      {maps && <Keys title="Map" keys={replay ? MAP.slice(0, 1) : MAP} />}
      <Keys title="Lanes" keys={LANES} />
      {!replay && drives && (
        <p class="muted small">
          Letting go ends your driving; so do another window, a hidden tab, a lost pointer, an unplugged gamepad and a
          cut link. To a goal the robot goes by itself, until Space, Cancel or the emergency stop ends that. Keys typed
          in a field never drive.
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
                <kbd key={name}>{name}</kbd>
              ))}
            </dt>
            <dd>{words}</dd>
          </div>
        ))}
      </dl>
    </section>
  );
}

/** The shortcuts sheet. */

import { useEffect, useRef } from "preact/hooks";
import { useApp } from "../state/context";
import { CloseIcon } from "./icons";

const KEYS: [string[], string][] = [
  [["W", "A", "S", "D"], "Drive while held; so do the arrow keys"],
  [["Shift"], "Held: slowly"],
  [["O"], "Held while driving: crawl, whatever stands in the way. Only your eyes stop the robot then"],
  [["Space"], "Stop driving: every key must be pressed anew"],
  [
    ["Esc"],
    "Emergency stop, from anywhere on the page; it withdraws the goal, too, and stays latched until it is released. While the robot stands without a goal, it closes this sheet or gives up what is begun on the map instead",
  ],
  [["V"], "Speak through the robot while held"],
  [["?"], "This sheet"],
];
const PAD: [string[], string][] = [
  [["L1", "R1"], "Hold one of them to drive (the dead-man)"],
  [["Left stick"], "Forward, backward, turn; the right stick turns too"],
  [["L2", "R2"], "Held while driving: crawl, whatever stands in the way"],
  [["Y", "△"], "Return to where the map began"],
  [["B", "○"], "Emergency stop"],
];
const RECORDING: [string[], string][] = [
  [["Space"], "Play and pause"],
  [[",", "."], "Step back and forward"],
  [["←", "→"], "Five seconds back and forward"],
  [["Home", "End"], "To the beginning, to the end"],
  [["?"], "This sheet; Esc closes it"],
];
const MAP: [string[], string][] = [
  [["M"], "The map over all of the view, and back"],
  [["G"], "Go to, with the map in focus: press on the place and drag to where it should look, or use the keys below"],
  [["↑ ↓", "← →"], "With the map in focus: move the cursor, with Shift further"],
  [["Enter"], "A goal there: arrows turn it, Enter sends it; a zone's corner with its tool"],
  [["+", "−", "⌫"], "Zoom; take back the goal or the last corner"],
];
const LANES: [string[], string][] = [
  [["← →", "↑ ↓"], "With the lanes in focus: move the cursor that tells why"],
  [["+", "−", "P"], "Zoom, pause. Wheel, pinch and drag do the same"],
];

export function Help() {
  const { store } = useApp();
  const close = useRef<HTMLButtonElement>(null);
  const open = store.help.value;
  const replay = store.replay.value;
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
      <Keys title="Keyboard" keys={replay ? RECORDING : KEYS} />
      {!replay && <Keys title="Gamepad" keys={PAD} />}
      <Keys title="Map" keys={replay ? MAP.slice(0, 1) : MAP} />
      <Keys title="Lanes" keys={LANES} />
      {!replay && (
        <p class="muted small">
          Letting go stops the robot; so do another window, a hidden tab, a lost pointer, an unplugged gamepad and a cut
          link. Keys typed in a field never drive.
        </p>
      )}
    </div>
  );
}

function Keys({ title, keys }: { title: string; keys: [string[], string][] }) {
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

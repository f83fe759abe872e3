/** The touch stick: held while a finger or the mouse holds it, on Pointer Events. It also shows what other inputs do. */

import { useRef } from "preact/hooks";
import { type Axes, CENTRE } from "./axes";
import type { DriveController } from "./driveController";

const DEADBAND = 0.08;

export function Stick({ drive, words }: { drive: DriveController; words: string }) {
  const disc = useRef<HTMLDivElement>(null);
  const pointer = useRef<number | null>(null);
  const { command, factor } = drive.state.value;
  const strafes = drive.stickStrafes.value;
  const refused = drive.refusal.value !== null;

  const axesAt = (event: PointerEvent): Axes => {
    const box = disc.current!.getBoundingClientRect();
    const reach = box.width * 0.36;
    const x = (event.clientX - box.left - box.width / 2) / reach;
    const y = (event.clientY - box.top - box.height / 2) / reach;
    const size = Math.hypot(x, y);
    if (size < DEADBAND) return CENTRE;
    const shrink = size > 1 ? 1 / size : 1;
    const aside = -x * shrink;
    return { linear: -y * shrink, angular: strafes ? 0 : aside, lateral: strafes ? aside : 0 };
  };
  const end = (event: PointerEvent) => {
    if (event.pointerId !== pointer.current) return;
    pointer.current = null;
    drive.input({ type: "stick-end" });
  };
  const lose = (event: PointerEvent) => {
    if (event.pointerId !== pointer.current) return;
    pointer.current = null;
    drive.release();
  };

  // Where the hand is: the command without the speed preset, kept on the disc when two keys point to its corner.
  const aside = strafes ? command.lateral : command.angular;
  const size = Math.max(factor, Math.hypot(command.linear, aside), 0.01);
  const reach = command.held ? 36 / size : 0;
  const knob = `translate(${-aside * reach}%, ${-command.linear * reach}%)`;
  return (
    <div
      ref={disc}
      class={`stick ${command.held ? "held" : ""} ${refused ? "refused" : ""}`}
      data-testid="stick"
      role="slider"
      tabIndex={0}
      aria-label="Drive stick: hold and push, or hold the arrow keys"
      aria-orientation="vertical"
      aria-valuemin={-100}
      aria-valuemax={100}
      aria-valuenow={Math.round(command.linear * 100)}
      aria-valuetext={words}
      aria-disabled={refused}
      onPointerDown={(event) => {
        if (event.button !== 0 || pointer.current !== null) return;
        event.preventDefault();
        disc.current!.focus({ preventScroll: true });
        disc.current!.setPointerCapture(event.pointerId);
        pointer.current = event.pointerId;
        drive.grasp(axesAt(event));
      }}
      onPointerMove={(event) => {
        if (event.pointerId === pointer.current) drive.input({ type: "stick-move", axes: axesAt(event) });
      }}
      onPointerUp={end}
      onPointerCancel={lose}
      onLostPointerCapture={lose}
      onContextMenu={(event) => event.preventDefault()}
    >
      <svg viewBox="0 0 100 100" aria-hidden="true">
        <circle class="stick-rim" cx="50" cy="50" r="48" />
        <path class="stick-arrow" d="M50 7l6 8H44zM50 93l6-8H44zM7 50l8-6v12zM93 50l-8-6v12z" />
      </svg>
      <div class="stick-travel" style={{ transform: knob }}>
        <div class="stick-knob" />
      </div>
    </div>
  );
}

/** A touch stick: held while a finger or the mouse holds it, on Pointer Events. It also shows what other inputs do. */

import { useRef } from "preact/hooks";
import { t } from "../i18n";
import type { DriveController } from "./driveController";

const DEADBAND = 0.08;

/** Where a stick is: up and left, −1…1. */
interface Deflection {
  up: number;
  left: number;
}

/** The base's stick. */
export function Stick({ drive, words }: { drive: DriveController; words: string }) {
  const { command, factor } = drive.state.value;
  const strafes = drive.stickStrafes.value;
  const axes = ({ up, left }: Deflection) => ({
    linear: up,
    angular: strafes ? 0 : left,
    lateral: strafes ? left : 0,
  });
  return (
    <Disc
      testid="stick"
      label={t("Drive stick: hold and push, or hold the arrow keys")}
      words={words}
      held={command.held}
      refused={drive.refusal.value !== null}
      at={{ up: command.linear, left: strafes ? command.lateral : command.angular }}
      factor={factor}
      onGrasp={(at) => drive.grasp(axes(at))}
      onMove={(at) => drive.input({ type: "stick-move", axes: axes(at) })}
      onEnd={() => drive.input({ type: "stick-end" })}
      onLose={() => drive.release()}
    />
  );
}

/** The head's stick. */
export function HeadStick({ drive, words }: { drive: DriveController; words: string }) {
  const { command, factor } = drive.state.value;
  const axes = ({ up, left }: Deflection) => ({ tilt: up, pan: left });
  return (
    <Disc
      testid="head-stick"
      label={t("Head stick: hold and push, or hold the keys I, J, K and L")}
      words={words || t("held")}
      held={command.head_held}
      refused={drive.refusal.value !== null}
      at={{ up: command.tilt, left: command.pan }}
      factor={factor}
      onGrasp={(at) => drive.graspHead(axes(at))}
      onMove={(at) => drive.input({ type: "head-move", axes: axes(at) })}
      onEnd={() => drive.input({ type: "head-end" })}
      onLose={() => drive.release()}
    />
  );
}

interface DiscProps {
  testid: string;
  label: string;
  words: string;
  held: boolean;
  refused: boolean;
  at: Deflection;
  factor: number;
  onGrasp(at: Deflection): void;
  onMove(at: Deflection): void;
  onEnd(): void;
  onLose(): void;
}

function Disc({ testid, label, words, held, refused, at, factor, onGrasp, onMove, onEnd, onLose }: DiscProps) {
  const disc = useRef<HTMLDivElement>(null);
  const pointer = useRef<number | null>(null);

  const deflection = (event: PointerEvent): Deflection => {
    const box = disc.current!.getBoundingClientRect();
    const reach = box.width * 0.36;
    const x = (event.clientX - box.left - box.width / 2) / reach;
    const y = (event.clientY - box.top - box.height / 2) / reach;
    const size = Math.hypot(x, y);
    if (size < DEADBAND) return { up: 0, left: 0 };
    const shrink = size > 1 ? 1 / size : 1;
    return { up: -y * shrink, left: -x * shrink };
  };
  const over = (event: PointerEvent, then: () => void) => {
    if (event.pointerId !== pointer.current) return;
    pointer.current = null;
    then();
  };

  // Where the hand is: the command without the speed preset, kept on the disc when two keys point to its corner.
  const size = Math.max(factor, Math.hypot(at.up, at.left), 0.01);
  const reach = held ? 36 / size : 0;
  const knob = `translate(${-at.left * reach}%, ${-at.up * reach}%)`;
  return (
    <div
      ref={disc}
      class={`stick ${testid} ${held ? "held" : ""} ${refused ? "refused" : ""}`}
      data-testid={testid}
      role="slider"
      tabIndex={0}
      aria-label={label}
      aria-orientation="vertical"
      aria-valuemin={-100}
      aria-valuemax={100}
      aria-valuenow={Math.round(at.up * 100)}
      aria-valuetext={words}
      aria-disabled={refused}
      onPointerDown={(event) => {
        if (event.button !== 0 || pointer.current !== null) return;
        event.preventDefault();
        disc.current!.focus({ preventScroll: true });
        disc.current!.setPointerCapture(event.pointerId);
        pointer.current = event.pointerId;
        onGrasp(deflection(event));
      }}
      onPointerMove={(event) => {
        if (event.pointerId === pointer.current) onMove(deflection(event));
      }}
      onPointerUp={(event) => over(event, onEnd)}
      onPointerCancel={(event) => over(event, onLose)}
      onLostPointerCapture={(event) => over(event, onLose)}
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

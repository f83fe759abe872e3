/** The stops in their order, with the leg that leads to each: dragged, or moved with Alt and the arrow keys. */

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { t } from "../i18n";
import type { Stop } from "../protocol/types";
import { useApp } from "../state/context";
import { ChevronIcon, ChevronUpIcon, QrIcon, WarnIcon } from "../ui/icons";
import { StopForm } from "./StopForm";
import { stopMoved, textOf } from "./tourEdits";
import { problemsAt, worst } from "./tourProblems";
import { type Leg, legWords } from "./tourRoute";

export function StopList() {
  const { tours, tourRoute } = useApp();
  const tour = tours.draft.value!;
  const dragged = useSignal<string | null>(null);
  const list = useRef<HTMLOListElement>(null);
  const said = useSignal("");
  const move = (id: string, to: number) => {
    if (to < 0 || to >= tour.stops.length) return;
    void tours.edit((before) => stopMoved(before, id, to));
    const title = textOf(tour.stops.find((stop) => stop.id === id)?.title, tour.languages);
    said.value = t("{title} is stop {number} of {stops}.", { title, number: to + 1, stops: tour.stops.length });
    // The keyboard stays with the stop that it moves.
    requestAnimationFrame(() =>
      list.current?.querySelector<HTMLElement>(`[data-stop="${id}"] .tour-stop-open`)?.focus(),
    );
  };
  const home = tourRoute.legs.value.find(({ stop }) => stop === null);
  return (
    <>
      <ol class="tour-stops" ref={list} data-testid="tour-stops">
        {tour.stops.map((stop, number) => (
          <Row
            key={stop.id}
            stop={stop}
            number={number}
            leg={tourRoute.legs.value.find((leg) => leg.stop === stop.id)}
            dragged={dragged.value === stop.id}
            onDrag={(on) => (dragged.value = on ? stop.id : null)}
            onOver={() => {
              const id = dragged.peek();
              const from = tour.stops.findIndex((one) => one.id === id);
              if (id !== null && from >= 0 && from !== number) move(id, number);
            }}
            onMove={(by) => move(stop.id, number + by)}
          />
        ))}
      </ol>
      {tour.stops.length === 0 && (
        <p class="empty">{t("No stop yet. Make one where the robot is, or before a poster that it has found.")}</p>
      )}
      {home && <LegLine leg={home} to="Home" />}
      <p class="visually-hidden" aria-live="polite">
        {said.value}
      </p>
    </>
  );
}

interface RowProps {
  stop: Stop;
  number: number;
  leg: Leg | undefined;
  dragged: boolean;
  onDrag: (on: boolean) => void;
  onOver: () => void;
  onMove: (by: number) => void;
}

function Row({ stop, number, leg, dragged, onDrag, onOver, onMove }: RowProps) {
  const { stops, tours } = useApp();
  const tour = tours.draft.value!;
  const problems = problemsAt(tours.problems.value, `stops.${number}`);
  const open = stops.open.value === stop.id;
  const bad = worst(problems);
  return (
    <li
      class={`tour-stop ${open ? "open" : ""} ${stop.left_out ? "left-out" : ""} ${dragged ? "dragged" : ""}`}
      data-testid="tour-stop"
      data-stop={stop.id}
      data-place={stop.place}
      data-problems={problems.length}
      draggable={!open}
      onDragStart={(event) => {
        event.dataTransfer?.setData("text/plain", stop.id); // without data some browsers drag nothing
        onDrag(true);
      }}
      onDragEnd={() => onDrag(false)}
      onDragOver={(event) => event.preventDefault()}
      onDrop={(event) => {
        event.preventDefault();
        onOver();
      }}
    >
      {leg && <LegLine leg={leg} to={`Stop ${number + 1}`} />}
      <div class="tour-stop-head">
        <button
          type="button"
          class="tour-stop-open"
          data-testid="stop-open"
          aria-expanded={open}
          title={t("Alt+↑ and Alt+↓ move it")}
          onClick={() => (stops.open.value = open ? null : stop.id)}
          onKeyDown={(event) => {
            const by = event.key === "ArrowUp" ? -1 : event.key === "ArrowDown" ? 1 : 0;
            if (!event.altKey || by === 0) return;
            event.preventDefault();
            event.stopPropagation();
            onMove(by);
          }}
        >
          <span class="tour-number">{number + 1}</span>
          <span class="tour-stop-title">{textOf(stop.title, tour.languages)}</span>
          {stop.poster !== null && <QrIcon />}
          {bad && (
            <span class={`tour-flag ${bad}`} title={problems.map(({ message }) => message).join("\n")}>
              <WarnIcon />
            </span>
          )}
        </button>
        <button
          type="button"
          class="icon-button"
          data-testid="stop-up"
          aria-label={t("Earlier")}
          disabled={number === 0}
          onClick={() => onMove(-1)}
        >
          <ChevronUpIcon />
        </button>
        <button
          type="button"
          class="icon-button"
          data-testid="stop-down"
          aria-label={t("Later")}
          disabled={number === tour.stops.length - 1}
          onClick={() => onMove(1)}
        >
          <ChevronIcon />
        </button>
      </div>
      {open && <StopForm stop={stop} number={number} />}
    </li>
  );
}

function LegLine({ leg, to }: { leg: Leg; to: string }) {
  return (
    <p class={`tour-leg ${leg.state}`} data-testid="tour-leg" data-state={leg.state}>
      <span class="visually-hidden">{to}: </span>
      {legWords(leg)}
    </p>
  );
}

/** What a lane showed at the time under the cursor, and why. */

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { fromRobot, langOf, t } from "../i18n";
import {
  clockSpan,
  clockTime,
  divisor,
  divisorLines,
  number,
  percent,
  reasonText,
  spaced,
  stateWord,
} from "../ui/format";
import { StateMark } from "../ui/icons";
import type { Hit } from "./chart";
import { EVENTS_PX } from "./drawEvents";
import { placeBeside } from "./viewport";

const WIDTH = 300;
const GAP = 4;

/** `area`: the lanes on the screen; `top`: where they begin to be seen, which is below what they are steered with. */
export function Tooltip({ hit, area, top, now }: { hit: Hit; area: DOMRect; top: number; now: number }) {
  const box = useRef<HTMLDivElement>(null);
  const [high, setHigh] = useState(0);
  useLayoutEffect(() => setHigh(box.current!.offsetHeight));
  const { sample, events } = hit;
  const wide = Math.min(WIDTH, window.innerWidth - 16);
  const at = area.left + hit.x;
  const x = Math.max(8, Math.min(window.innerWidth - wide - 8, at + (at > area.right - wide ? -wide - 14 : 14)));
  const bottom = document.querySelector(".dock")?.getBoundingClientRect().top ?? window.innerHeight;
  const rowTop = area.top + EVENTS_PX + hit.y;
  const beside = placeBeside(rowTop, rowTop + hit.height, high + GAP, top, bottom - GAP);
  // What is too long for the lanes may cover what is above them.
  const y = Math.max(GAP, Math.min(beside, bottom - GAP - high));
  return (
    <div
      class="tooltip"
      ref={box}
      role="status"
      data-testid="lane-tooltip"
      style={{ left: `${x}px`, top: `${y}px`, width: `${wide}px` }}
    >
      <p class="tooltip-head">
        <b>{hit.name ? spaced(hit.name) : t("Events")}</b>
        <span>
          {clockTime(hit.stamp)} · {number(hit.stamp - now, 1)} s
        </span>
      </p>
      {sample ? (
        <>
          <dl>
            <div>
              <dt>
                <i class="key-intensity" />
                {t("Intensity")}
              </dt>
              <dd>{number(sample.intensity)}</dd>
            </div>
            <div>
              <dt>
                <i class="key-utility" />
                {t("Utility")}
              </dt>
              <dd>{number(sample.utility)}</dd>
            </div>
            <div>
              <dt>
                <i class="key-measured" />
                {t("Measured")}
              </dt>
              <dd>{percent(sample.rate)}</dd>
            </div>
            <div>
              <dt>
                <i class="key-phi" />φ
              </dt>
              <dd>{divisor(sample.divisor)}</dd>
            </div>
          </dl>
          {divisorLines(sample.divisors).length > 0 && (
            <ul class="tooltip-filters" aria-label={t("φ of each input")}>
              {divisorLines(sample.divisors).map((line) => (
                <li key={line}>{line}</li>
              ))}
            </ul>
          )}
          <p class="tooltip-why">
            <StateMark state={sample.state} />
            <span>
              <b class="state-word">{stateWord(sample.state)}</b>
              {hit.exploited && t(", exploited")}
              {hit.idle !== null && t(", not exploited for {time}", { time: clockSpan(hit.idle) })}.{" "}
              <span lang={langOf(sample.text)}>{reasonText(sample.state, sample.text)}</span>
            </span>
          </p>
        </>
      ) : (
        hit.name && <p class="muted">{t("No data here.")}</p>
      )}
      {!hit.name && hit.folded.length === 0 && <p class="muted">{t("Nothing here.")}</p>}
      {hit.folded.slice(-4).map((mark) => (
        <p key={`${mark.kind} ${mark.subject}`} class="tooltip-event">
          <i class="key-mark" />
          {mark.count > 1
            ? t("{count}×, the last: {text}", { count: mark.count, text: fromRobot(mark.text) })
            : fromRobot(mark.text)}
        </p>
      ))}
      {events.slice(-3).map((event) => (
        <p key={event.id} class="tooltip-event">
          <i class="key-mark" />
          <span lang={langOf(event.text)}>{fromRobot(event.text)}</span>
        </p>
      ))}
    </div>
  );
}

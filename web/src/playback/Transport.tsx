/** The transport of a recording: play, step, speed, and the timeline to be dragged. */

import type { ComponentChildren } from "preact";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { clockSpan, clockTime, number } from "../ui/format";
import { BackIcon, PauseIcon, PlayIcon, ReplayIcon, StepIcon } from "../ui/icons";
import { isDated, SPEEDS, slowerThanAsked, speedWord, spokenSpan } from "./transport";

export function Transport() {
  const { store, playback } = useApp();
  const state = store.playback.value;
  if (!state) return null;
  const { begin, end, playing, phase } = state;
  const position = playback.wanted.value ?? state.position;
  const at = Math.max(0, position - begin);
  const whole = Math.max(0.01, end - begin);
  const rate = store.clock.rate;
  const ended = phase === "ended" && playback.wanted.value === null;
  const play = playing ? t("Pause") : ended ? t("Play again") : t("Play");
  return (
    <section
      class={`transport panel ${phase}`}
      aria-label={t("Recording")}
      data-testid="transport"
      data-phase={playback.wanted.value === null ? phase : "seeking"}
      data-playing={playing}
      data-position={position}
      data-begin={begin}
      data-end={end}
      data-speed={state.speed ?? "max"}
    >
      <div class="transport-buttons" role="group" aria-label={t("Playback")}>
        <Button id="back" label={t("Step back")} keys="," onPress={() => playback.act("back")}>
          <BackIcon />
        </Button>
        <Button id="play" label={play} keys="Space" main onPress={() => playback.act("toggle")}>
          {playing ? <PauseIcon /> : ended ? <ReplayIcon /> : <PlayIcon />}
        </Button>
        <Button id="step" label={t("Step forward")} keys="." onPress={() => playback.act("step")}>
          <StepIcon />
        </Button>
      </div>
      <p class="transport-position">
        <b data-testid="playback-position">{clockSpan(at, playing ? 0 : 1)}</b>
        {isDated(begin) && (
          <span class="muted" title={t("Your local time when this was recorded")}>
            {clockTime(position)}
          </span>
        )}
      </p>
      <input
        class="timeline"
        type="range"
        data-playback-keys
        data-testid="timeline"
        aria-label={t("Position in the recording")}
        aria-valuetext={t("{at} of {whole}", { at: spokenSpan(at), whole: spokenSpan(whole) })}
        aria-keyshortcuts="ArrowLeft ArrowRight Home End"
        min={0}
        max={whole}
        step={0.01}
        value={at}
        style={{ "--fill": `${(100 * at) / whole}%` }}
        onInput={(event) => playback.seek(begin + Number(event.currentTarget.value))}
      />
      <p class="transport-end">
        <b data-testid="playback-length">{clockSpan(whole)}</b>
        {isDated(begin) && <span class="muted">{clockTime(end)}</span>}
      </p>
      <label class="transport-speed">
        <span class="visually-hidden">{t("Speed")}</span>
        <select
          data-testid="playback-speed"
          value={state.speed ?? "max"}
          onChange={(event) => {
            const value = event.currentTarget.value;
            playback.speed(value === "max" ? null : Number(value));
            event.currentTarget.blur(); // Space plays again
          }}
        >
          {speeds(state.speed).map((speed) => (
            <option key={speed} value={speed ?? "max"}>
              {speedWord(speed)}
            </option>
          ))}
        </select>
        <Pace asked={state.speed} slow={slowerThanAsked(state, rate)} rate={playing ? rate : null} />
      </label>
      {state.problem && (
        <p class="transport-problem" role="status" data-testid="playback-problem">
          {t("The recording is damaged: {problem}.", { problem: state.problem })}
        </p>
      )}
    </section>
  );
}

/** Under the speed: what it really is, where that is another. */
function Pace({ asked, slow, rate }: { asked: number | null; slow: boolean; rate: number | null }) {
  const shown = rate !== null && (asked === null || slow);
  return (
    <span
      class={`transport-pace ${slow ? "slow" : ""}`}
      title={slow ? t("This computer cannot play the recording any faster") : t("As fast as this computer can")}
    >
      {shown ? t("runs at {rate}×", { rate: number(rate, rate < 10 ? 1 : 0) }) : ""}
    </span>
  );
}

/** The usual speeds, and the one that is: a replay may have been started at any. */
function speeds(asked: number | null): (number | null)[] {
  const all = new Set<number>(SPEEDS);
  if (asked !== null) all.add(asked);
  return [...[...all].sort((a, b) => a - b), null];
}

function Button(props: {
  id: string;
  label: string;
  keys: string;
  main?: boolean;
  onPress: () => void;
  children: ComponentChildren;
}) {
  return (
    <button
      type="button"
      class={props.main ? "transport-play" : "icon-button"}
      aria-label={props.label}
      aria-keyshortcuts={props.keys}
      title={`${props.label} (${props.keys})`}
      data-testid={`playback-${props.id}`}
      onClick={(event) => {
        props.onPress();
        if (event.detail > 0) event.currentTarget.blur(); // pressed with the mouse, Space goes on playing and pausing
      }}
    >
      {props.children}
    </button>
  );
}

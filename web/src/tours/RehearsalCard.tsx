/** In the editor: has the tour rehearsed, plays it on the map many times faster than life, lists what would go wrong. */

import { useSignal } from "@preact/signals";
import { fromRobot, t } from "../i18n";
import { useApp } from "../state/context";
import { clockSpan, sentence } from "../ui/format";
import { CloseIcon, PauseIcon, PlayIcon, WarnIcon } from "../ui/icons";
import { Choice, languageName } from "./parts";
import { problemsByStop, progressWords, resultWords, saidAt, speedOf, stateAt } from "./rehearsalPlay";
import { textOf } from "./tourEdits";
import { stateWord } from "./tourRunText";

export function RehearsalCard() {
  const { rehearsal, tours } = useApp();
  const tour = tours.draft.value!;
  const chosen = useSignal("");
  const report = rehearsal.report.value;
  const mine = report?.tour === tour.id ? report : null;
  const running = report?.state === "running";
  const language = tour.languages.includes(chosen.value) ? chosen.value : (tour.languages[0] ?? "en");
  const problem = rehearsal.refusal.value || (mine?.state === "failed" ? mine.problem : "");
  return (
    <section
      class="rehearsal"
      aria-label={t("Rehearsal")}
      data-testid="rehearsal"
      data-state={mine?.state ?? "none"}
      data-led={mine?.can_be_led ?? ""}
    >
      <div class="rehearsal-begin">
        {running ? (
          <>
            <span class="spinner" />
            <span role="status" data-testid="rehearsal-progress">
              {mine ? progressWords(report) : t("{tour} is being rehearsed", { tour: report.tour })}
            </span>
            <button
              type="button"
              class="button small"
              data-testid="rehearsal-cancel"
              onClick={() => void rehearsal.cancel()}
            >
              {t("Cancel")}
            </button>
          </>
        ) : (
          <>
            <button
              type="button"
              class="button"
              data-testid="rehearse"
              title={t("Play the tour on its map, without the robot")}
              disabled={!tours.allowed.value || tours.conflict.value !== null}
              onClick={() => void rehearsal.begin(language)}
            >
              <PlayIcon /> {t("Rehearse")}
            </button>
            {tour.languages.length > 1 && (
              <Choice
                label={t("Visitors speak")}
                value={language}
                testid="rehearsal-language"
                options={tour.languages.map((tag) => [tag, languageName(tag)] as const)}
                onChange={(tag) => (chosen.value = tag)}
              />
            )}
          </>
        )}
      </div>
      {problem && (
        <p class="inline-note error" role="alert" data-testid="rehearsal-problem">
          <WarnIcon />
          <span>{problem}</span>
        </p>
      )}
      <Played />
    </section>
  );
}

function Played() {
  const { rehearsal, tours } = useApp();
  const result = rehearsal.result.value;
  if (!result) return null;
  const at = rehearsal.at.value;
  const state = stateAt(result, at);
  const said = saidAt(result, at);
  const stop = tours.draft.value?.stops.find(({ id }) => id === state?.stop);
  const playing = rehearsal.playing.value;
  return (
    <>
      <p class="small" role="status" data-testid="rehearsal-result">
        {resultWords(result)}
      </p>
      <div class="rehearsal-transport">
        <button
          type="button"
          class="icon-button"
          data-testid="rehearsal-play"
          aria-label={playing ? t("Pause") : t("Play")}
          title={t("{speed} times faster than life", { speed: Math.round(speedOf(result)) })}
          onClick={() => rehearsal.play()}
        >
          {playing ? <PauseIcon /> : <PlayIcon />}
        </button>
        <input
          type="range"
          aria-label={t("Moment of the rehearsal")}
          data-testid="rehearsal-at"
          min={0}
          max={result.duration_s}
          step={0.1}
          value={at}
          onInput={(event) => (rehearsal.at.value = Number(event.currentTarget.value))}
        />
        <span class="small">{clockSpan(at)}</span>
        <button
          type="button"
          class="icon-button"
          data-testid="rehearsal-close"
          aria-label={t("Close the rehearsal")}
          title={t("Close the rehearsal")}
          onClick={() => void rehearsal.cancel()}
        >
          <CloseIcon />
        </button>
      </div>
      {state && (
        <p class="small muted" data-testid="rehearsal-state">
          {`${stateWord(state.state)}${stop ? ` (${textOf(stop.title, [result.language]) || stop.id})` : ""}${state.reason ? t(": {reason}", { reason: fromRobot(state.reason) }) : ""}`}
        </p>
      )}
      {/* It keeps its room: nothing below may jump many times a second. */}
      <p class="rehearsal-said" lang={result.language} data-testid="rehearsal-said">
        {said}
      </p>
      <Problems />
    </>
  );
}

/** Each leads to its stop, and to the moment when it was found. */
function Problems() {
  const { rehearsal, stops, tours } = useApp();
  const tour = tours.draft.value!;
  const found = [...problemsByStop(rehearsal.result.value!)];
  if (found.length === 0)
    return (
      <p class="small rehearsal-fine" data-testid="rehearsal-fine">
        {t("Nothing went wrong.")}
      </p>
    );
  return (
    <ul class="tour-problems" aria-label={t("What would go wrong")}>
      {found.flatMap(([id, problems]) => {
        const stop = tour.stops.find((each) => each.id === id);
        return problems.map(({ severity, message, at_s }) => (
          <li key={`${id} ${at_s} ${message}`} class={severity} data-testid="rehearsal-found" data-stop={id}>
            <WarnIcon />
            <span>
              {stop && (
                <button
                  type="button"
                  class="rehearsal-stop"
                  onClick={() => {
                    stops.open.value = id;
                    rehearsal.playing.value = false;
                    if (at_s !== null) rehearsal.at.value = at_s;
                  }}
                >
                  {textOf(stop.title, tour.languages) || id}
                </button>
              )}{" "}
              {sentence(message)}
            </span>
          </li>
        ));
      })}
    </ul>
  );
}

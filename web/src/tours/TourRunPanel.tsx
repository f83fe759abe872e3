/** Leads tours: begins one, shows how it goes and why, and steers it. */

import { useSignal } from "@preact/signals";
import { fromRobot, langOf, plural, t } from "../i18n";
import { LoadForm } from "../map/MapRow";
import type { TourProgress } from "../protocol/types";
import { subtitleOf } from "../speech/subtitle";
import { useApp } from "../state/context";
import { sentence } from "../ui/format";
import { PersonIcon, PlayIcon, WarnIcon } from "../ui/icons";
import { QrPicture } from "../ui/QrPicture";
import { Choice, languageName } from "./parts";
import { TourSteering } from "./TourSteering";
import { textOf } from "./tourEdits";
import {
  buttonWords,
  defaultWords,
  idWords,
  pauseWords,
  peopleWords,
  standsWords,
  stateWords,
  stopWords,
} from "./tourRunText";

export function TourRun() {
  const { tourRun, tours } = useApp();
  const progress = tourRun.progress.value;
  // While a tour is edited, and none is led, the room is the editor's.
  if (!progress && tours.draft.value) return null;
  return (
    <section
      class={`card tour-run ${progress?.state ?? "none"}`}
      aria-label={t("Leading a tour")}
      data-testid="tour-run"
      data-state={progress?.state ?? "none"}
      data-stop={progress?.stop ?? ""}
    >
      {progress ? <UnderWay progress={progress} /> : <Begin />}
      {tourRun.refusal.value && (
        <p class="inline-note error" role="alert" data-testid="tour-run-problem">
          <WarnIcon />
          <span>{tourRun.refusal.value}</span>
        </p>
      )}
    </section>
  );
}

/** Which tour, in which language, and whether now or when visitors come. */
function Begin() {
  const { store, tourRun, tours } = useApp();
  const chosen = tourRun.chosen.value;
  const list = tours.list.value?.tours ?? [];
  if (store.replay.value) return <h2>{t("No tour is under way")}</h2>;
  if (!chosen) return <h2>{list.length === 0 ? t("No tour to lead yet") : t("No tour can be read")}</h2>;
  const ready = tourRun.allowed.value && chosen.errors === 0;
  const { languages } = chosen;
  const language = languages.includes(tourRun.language.value) ? tourRun.language.value : (languages[0] ?? "");
  return (
    <>
      <h2>{t("Lead a tour")}</h2>
      <div class="tour-run-choice">
        <Choice
          label={t("Tour")}
          value={chosen.id}
          testid="tour-run-tour"
          options={list
            .filter(({ problem }) => problem === null)
            .map(({ id, title, languages }) => [id, textOf(title, languages) || id] as const)}
          onChange={(id) => (tourRun.wanted.value = id)}
        />
        <Choice
          label={t("It speaks")}
          value={language}
          testid="tour-run-language"
          options={languages.map((tag) => [tag, languageName(tag)] as const)}
          onChange={(tag) => (tourRun.language.value = tag)}
        />
      </div>
      {chosen.errors > 0 && (
        <p class="tour-lack small">
          {plural(
            chosen.errors,
            "{count} thing is missing: open the tour to see what.",
            "{count} things are missing: open the tour to see what.",
          )}
        </p>
      )}
      <OnAnotherMap key={chosen.id} map={chosen.map} />
      <div class="tour-run-buttons two-ways">
        <button
          type="button"
          class="button accent"
          data-testid="tour-run-start"
          disabled={!ready}
          onClick={() => void tourRun.begin("now")}
        >
          <PlayIcon /> {t("Begin now")}
        </button>
        <button
          type="button"
          class="button"
          data-testid="tour-run-wait"
          title={t("It begins when visitors or the schedule begin it, again and again")}
          disabled={!ready}
          onClick={() => void tourRun.begin("visitors")}
        >
          <PersonIcon /> {t("Wait for visitors")}
        </button>
      </div>
    </>
  );
}

/** A tour is led on its own map alone: which has to be loaded first, here. */
function OnAnotherMap({ map }: { map: string }) {
  const { maps } = useApp();
  const open = useSignal(false);
  const kept = maps.list.value?.maps.find(({ name, problem }) => name === map && !problem);
  const used = maps.inUse.value;
  if (!kept || used === map) return null;
  return (
    <div class="tour-run-map" data-testid="tour-run-map">
      <p class="tour-lack small">
        {used
          ? t("It is on the map {map}, and {used} is in use.", { map, used })
          : t("It is on the map {map}, which is not loaded yet.", { map })}
      </p>
      {open.value ? (
        <LoadForm kept={kept} onDone={() => (open.value = false)} />
      ) : (
        <button type="button" class="button" data-testid="tour-run-load" onClick={() => (open.value = true)}>
          {t("Load the map {map}…", { map })}
        </button>
      )}
      {maps.problem.value && <p class="field-error">{maps.problem.value}</p>}
    </div>
  );
}

function UnderWay({ progress }: { progress: TourProgress }) {
  const { store } = useApp();
  const stopped = store.stopped.value;
  const pause = pauseWords(progress, stopped);
  const why = sentence(progress.reason) || standsWords(progress, store.of("navigation").value);
  return (
    <>
      <h2 class="card-head">
        <span class="tour-name">{textOf(progress.title, progress.languages)}</span>
        <span class="muted small">{languageName(progress.language)}</span>
      </h2>
      <div role="status" class="tour-run-state">
        <b data-testid="tour-run-state">{stateWords(progress)}</b>
        {why && (
          <span class="muted" data-testid="tour-run-reason">
            {why}
          </span>
        )}
        {progress.stop && <span data-testid="tour-run-stop">{stopWords(progress)}</span>}
      </div>
      <Dots progress={progress} />
      <Said progress={progress} />
      {pause && (
        <p class="inline-note warn" role="alert" data-testid="tour-run-held">
          <WarnIcon />
          <span>
            {pause}
            {progress.question && (
              <span data-testid="tour-run-default"> {defaultWords(progress.question, store.seconds.value)}</span>
            )}
          </span>
        </p>
      )}
      <Question progress={progress} />
      {!store.replay.value && <TourSteering progress={progress} />}
      <p class="tour-run-people muted small" data-testid="tour-run-people">
        <PersonIcon /> {peopleWords(progress)}
      </p>
      <Failures progress={progress} />
      <ForPhones />
    </>
  );
}

/** The stops as a row of marks: done, skipped, here, to come. */
function Dots({ progress }: { progress: TourProgress }) {
  const { tourRun } = useApp();
  const stops = tourRun.stops.value;
  if (stops.length === 0) return null;
  return (
    <ol class="tour-run-dots" aria-label={t("Stops")}>
      {stops.map(({ id, title }) => {
        const state =
          id === progress.stop
            ? "here"
            : progress.presented.includes(id)
              ? "done"
              : progress.skipped.includes(id)
                ? "skipped"
                : "ahead";
        const name = textOf(title, progress.languages) || id;
        return (
          <li key={id} class={state} title={`${name}: ${state}`}>
            <span class="visually-hidden">{`${name}: ${state}`}</span>
          </li>
        );
      })}
    </ol>
  );
}

/** The sentence that is said; while nothing is, the text that the step has. */
function Said({ progress }: { progress: TourProgress }) {
  const { store } = useApp();
  const subtitle = subtitleOf(store.of("speech").value, store.now.value);
  if (subtitle)
    return (
      <p class="tour-run-said" data-testid="tour-run-said" lang={progress.language}>
        {subtitle.before}
        {subtitle.word && <mark>{subtitle.word}</mark>}
        {subtitle.after}
      </p>
    );
  const text = textOf(progress.text, [progress.language, ...progress.languages]);
  if (!text) return null;
  return (
    <p class="tour-run-said muted" data-testid="tour-run-said" lang={progress.language}>
      {text}
    </p>
  );
}

/** What the robot asks its operator; of a pause, Resume and the end are asked for below in any case. */
function Question({ progress }: { progress: TourProgress }) {
  const { store, tourRun } = useApp();
  const question = progress.question;
  if (!question || progress.state === "paused") return null;
  return (
    <div class="tour-run-question" role="alert" data-testid="tour-run-question">
      <b lang={langOf(question.text)}>{fromRobot(question.text)}</b>
      <span class="small" data-testid="tour-run-default">
        {defaultWords(question, store.seconds.value)}
      </span>
      {!store.replay.value && (
        <span class="form-actions">
          {question.answers.map((answer) => (
            <button
              key={answer}
              type="button"
              class={`button small ${answer === question.answers[0] ? "accent" : ""}`}
              data-testid={`tour-answer-${answer}`}
              disabled={!tourRun.allowed.value || !progress.buttons.includes(answer)}
              onClick={() => void tourRun.press({ button: answer })}
            >
              {buttonWords(answer, progress)}
            </button>
          ))}
        </span>
      )}
    </div>
  );
}

/** The way in for visitors' phones. */
function ForPhones() {
  const { tourRun } = useApp();
  const link = tourRun.link.value;
  if (!link || link.url === "") return null;
  return (
    <details class="tour-more" data-testid="tour-run-phones">
      <summary>{t("For visitors' phones")}</summary>
      {link.problem ? (
        <p class="inline-note warn" data-testid="tour-run-phones-problem">
          <WarnIcon />
          <span>{link.problem}</span>
        </p>
      ) : (
        <QrPicture code={link.code} label={t("Code for visitors' phones")} />
      )}
      <p class="small">
        <a href={link.url} target="_blank" rel="noreferrer" data-testid="tour-run-link">
          {link.url}
        </a>
      </p>
      <p class="muted small">
        {t(
          "It shows text, pictures and questions in their language, and lets them press what the tour waits for. Each run has another link.",
        )}
      </p>
    </details>
  );
}

function Failures({ progress }: { progress: TourProgress }) {
  if (progress.failures.length === 0) return null;
  return (
    <ul class="tour-problems" aria-label={t("What failed")}>
      {progress.failures.map(({ stop, what }, index) => (
        <li key={`${index} ${stop}`} data-testid="tour-run-failure" data-stop={stop}>
          <WarnIcon />
          <span>{stop ? t("{what}: {which}", { what: idWords(stop), which: fromRobot(what) }) : sentence(what)}</span>
        </li>
      ))}
    </ul>
  );
}

/** One stop: where it is, what the robot does there, what visitors may ask. */

import { t } from "../i18n";
import type { Question, Stop } from "../protocol/types";
import { useApp } from "../state/context";
import { FlagIcon, PlusIcon, TrashIcon } from "../ui/icons";
import { OwnFailureFields } from "./FailureFields";
import { Choice, FigureField, More, Problems, TextFields, TypedField, WordFields } from "./parts";
import { StepForm } from "./StepForm";
import { StepList } from "./StepList";
import { newQuestion, stopChanged, withoutStop } from "./tourEdits";
import { problemsAt } from "./tourProblems";

/** What is wrong with these is shown where they are edited. */
const FIELDS = ["title", "place", "do", "questions", "poster", "stand", "on_failure"] as const;

export function StopForm({ stop, number }: { stop: Stop; number: number }) {
  const { map, places, session, stops, store, tours } = useApp();
  const tour = tours.draft.value!;
  const { languages } = tour;
  const path = `stops.${number}`;
  const problems = problemsAt(
    tours.problems.value,
    path,
    FIELDS.map((field) => `${path}.${field}`),
  );
  const set = (change: Partial<Stop>) => void tours.edit((before) => stopChanged(before, stop.id, change));
  /** By what the stop is when the edit is made. */
  const edit = (change: (now: Stop) => Partial<Stop>) =>
    void tours.edit((before) => {
      const now = before.stops.find(({ id }) => id === stop.id);
      return now ? stopChanged(before, stop.id, change(now)) : before;
    });
  const known = places.all.value.some(({ id }) => id === stop.place);
  const options = places.all.value.map(({ id, name }) => [id, name] as const);
  return (
    <div class="tour-form tour-stop-form" data-testid="stop-form">
      <TextFields
        label={t("Title")}
        texts={stop.title}
        languages={languages}
        path={`${path}.title`}
        testid="stop-title"
        onDone={(title) => set({ title })}
      />
      <div class="tour-place">
        <Choice
          label={t("Place")}
          value={stop.place}
          path={`${path}.place`}
          testid="stop-at"
          options={
            known ? options : [[stop.place, t("{place} (not on this map)", { place: stop.place })] as const, ...options]
          }
          onChange={(place) => set({ place })}
        />
        {store.body.value.goes && (
          <button
            type="button"
            class="button"
            data-testid="stop-go"
            title={t("The robot drives there now")}
            disabled={!map.allowed.value || !known}
            onClick={() => void map.goToPlace(stop.place)}
          >
            <FlagIcon /> {t("Drive there")}
          </button>
        )}
      </div>
      <Problems problems={problems} />
      <StepList
        path={`${path}.do`}
        steps={stop.do}
        poster={stop.poster}
        onChange={(change) => edit((now) => ({ do: change(now.do) }))}
      />
      <More
        title={t("Questions")}
        about={stop.questions.length === 0 ? t("none") : String(stop.questions.length)}
        testid="stop-questions"
        paths={[`${path}.questions`]}
      >
        {stop.questions.map((question, at) => (
          <QuestionForm
            key={question.id}
            question={question}
            path={`${path}.questions.${at}`}
            languages={languages}
            poster={stop.poster}
            onChange={(change) =>
              edit((now) => ({
                questions: now.questions.map((one) => (one.id === question.id ? { ...one, ...change(one) } : one)),
              }))
            }
            onRemove={() => edit((now) => ({ questions: now.questions.filter(({ id }) => id !== question.id) }))}
          />
        ))}
        <button
          type="button"
          class="button small quiet"
          data-testid="question-add"
          onClick={() => edit((now) => ({ questions: [...now.questions, newQuestion(now, languages)] }))}
        >
          <PlusIcon /> {t("A question")}
        </button>
      </More>
      <More
        title={t("Words that lead here")}
        testid="stop-words"
        paths={[`${path}.words`]}
        about={Object.keys(stop.words).length === 0 ? t("none") : (stop.words[languages[0] ?? "en"] ?? []).join(", ")}
      >
        <WordFields
          label={t("Visitors say")}
          words={stop.words}
          languages={languages}
          path={`${path}.words`}
          placeholder={t("the arm")}
          onDone={(words) => set({ words })}
        />
      </More>
      <More
        title={t("Poster, how it stands")}
        testid="stop-stand"
        paths={[`${path}.poster`, `${path}.stand`]}
        {...(stop.poster === null ? {} : { about: stop.poster })}
      >
        <TypedField
          label={t("Text of the poster")}
          value={stop.poster ?? ""}
          path={`${path}.poster`}
          testid="stop-poster-text"
          placeholder={`HBBA:STOP/${stop.id.toUpperCase()}`}
          hint={t("Up to 20 capitals and digits are read from 3 m.")}
          onDone={(poster) => set({ poster: poster.trim() || null })}
        />
        {stop.poster !== null && (
          <a
            class="button small"
            href={session.tourRest.posters(tour.id, "a4", stop.id)}
            download={`${stop.id}-a4.pdf`}
          >
            {t("Its poster, A4")}
          </a>
        )}
        <Choice
          label={t("Faces")}
          value={stop.stand.face}
          path={`${path}.stand.face`}
          options={[
            ["visitors", t("the visitors")],
            ["poster", t("the poster")],
            ["place", t("as the place says")],
          ]}
          onChange={(face) => edit((now) => ({ stand: { ...now.stand, face } }))}
        />
        <div class="form-row two">
          <FigureField
            label={t("Stands within (m)")}
            value={stop.stand.tolerance_m}
            path={`${path}.stand.tolerance_m`}
            testid="stop-tolerance"
            onDone={(tolerance_m) => edit((now) => ({ stand: { ...now.stand, tolerance_m } }))}
          />
          <FigureField
            label={t("Is turned within (°)")}
            value={stop.stand.tolerance_rad}
            scale={180 / Math.PI}
            range={[3, 180]}
            path={`${path}.stand.tolerance_rad`}
            onDone={(tolerance_rad) => edit((now) => ({ stand: { ...now.stand, tolerance_rad } }))}
          />
        </div>
      </More>
      <More
        title={t("When this stop fails")}
        testid="stop-failure"
        paths={[`${path}.on_failure`]}
        about={ownWords(stop)}
      >
        <OwnFailureFields
          path={`${path}.on_failure`}
          rules={stop.on_failure}
          usual={tour.on_failure}
          onReach={(change) =>
            edit(({ on_failure }) => ({ on_failure: { ...on_failure, reach: { ...on_failure.reach, ...change } } }))
          }
          onPresent={(change) =>
            edit(({ on_failure }) => ({ on_failure: { ...on_failure, present: { ...on_failure.present, ...change } } }))
          }
        />
      </More>
      <div class="tour-stop-end">
        <label class="check">
          <input
            type="checkbox"
            data-testid="stop-left-out"
            checked={stop.left_out}
            onChange={(event) => set({ left_out: event.currentTarget.checked })}
          />
          <span>{t("Left out for now")}</span>
        </label>
        <button
          type="button"
          class="button small quiet"
          data-testid="stop-remove"
          onClick={() => {
            stops.open.value = null;
            void tours.edit((before) => withoutStop(before, stop.id));
          }}
        >
          <TrashIcon /> {t("Remove the stop")}
        </button>
      </div>
    </div>
  );
}

function ownWords({ on_failure: { reach, present } }: Stop): string {
  const own = [...Object.values(reach), ...Object.values(present)].some((value) => value !== null);
  return own ? t("its own rules") : t("as the tour");
}

function QuestionForm(props: {
  question: Question;
  path: string;
  languages: readonly string[];
  poster: string | null;
  onChange: (change: (now: Question) => Partial<Question>) => void;
  onRemove: () => void;
}) {
  const { tours } = useApp();
  const { question, path, languages, onChange } = props;
  return (
    <div class="tour-question" data-testid="question">
      <TextFields
        label={t("Question")}
        texts={question.question}
        languages={languages}
        path={`${path}.question`}
        onDone={(text) => onChange(() => ({ question: text }))}
      />
      <WordFields
        label={t("Words to hear")}
        words={question.words}
        languages={languages}
        path={`${path}.words`}
        placeholder={t("heavy, how heavy")}
        onDone={(words) => onChange(() => ({ words }))}
      />
      <span class="tour-label">{t("Answer")}</span>
      <ul class="tour-steps">
        <StepForm
          step={question.answer}
          path={`${path}.answer`}
          languages={languages}
          problems={problemsAt(tours.problems.value, `${path}.answer`)}
          poster={props.poster}
          onChange={(change) => onChange((now) => ({ answer: { ...now.answer, ...change } }))}
        />
      </ul>
      <Problems
        problems={problemsAt(tours.problems.value, path, [`${path}.answer`, `${path}.question`, `${path}.words`])}
      />
      <button type="button" class="button small quiet" onClick={props.onRemove}>
        <TrashIcon /> {t("Remove the question")}
      </button>
    </div>
  );
}

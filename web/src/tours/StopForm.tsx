/** One stop: where it is, what the robot does there, what visitors may ask. */

import type { Question, Stop } from "../protocol/types";
import { useApp } from "../state/context";
import { FlagIcon, PlusIcon, TrashIcon } from "../ui/icons";
import { Choice, More, Problems, TextFields, TypedField, WordFields } from "./parts";
import { StepForm } from "./StepForm";
import { StepList } from "./StepList";
import { newQuestion, stopChanged, withoutStop } from "./tourEdits";
import { problemsAt } from "./tourProblems";

export function StopForm({ stop, number }: { stop: Stop; number: number }) {
  const { map, places, session, stops, store, tours } = useApp();
  const tour = tours.draft.value!;
  const { languages } = tour;
  const path = `stops.${number}`;
  const problems = problemsAt(tours.problems.value, path, [`${path}.do`, `${path}.questions`]);
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
        label="Title"
        texts={stop.title}
        languages={languages}
        testid="stop-title"
        onDone={(title) => set({ title })}
      />
      <div class="tour-place">
        <Choice
          label="Place"
          value={stop.place}
          testid="stop-at"
          options={known ? options : [[stop.place, `${stop.place} (not on this map)`] as const, ...options]}
          onChange={(place) => set({ place })}
        />
        {store.body.value.goes && (
          <button
            type="button"
            class="button"
            data-testid="stop-go"
            title="The robot drives there now"
            disabled={!map.allowed.value || !known}
            onClick={() => void map.goToPlace(stop.place)}
          >
            <FlagIcon /> Drive there
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
      <More title={stop.questions.length === 0 ? "Questions" : `Questions (${stop.questions.length})`}>
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
          <PlusIcon /> A question
        </button>
      </More>
      <More title="Poster, how exactly it arrives">
        <TypedField
          label="Text of the poster"
          value={stop.poster ?? ""}
          testid="stop-poster-text"
          placeholder={`HBBA:STOP/${stop.id.toUpperCase()}`}
          hint="Up to 20 capitals and digits are read from 3 m."
          onDone={(poster) => set({ poster: poster.trim() || null })}
        />
        {stop.poster !== null && (
          <a class="button small" href={session.rest.posters(tour.id, "a4", stop.id)} download={`${stop.id}-a4.pdf`}>
            Its poster, A4
          </a>
        )}
        <Choice
          label="Faces"
          value={stop.stand.face}
          options={[
            ["visitors", "the visitors"],
            ["poster", "the poster"],
            ["place", "as the place says"],
          ]}
          onChange={(face) => edit((now) => ({ stand: { ...now.stand, face } }))}
        />
        <label class="check">
          <input
            type="checkbox"
            data-testid="stop-left-out"
            checked={stop.left_out}
            onChange={(event) => set({ left_out: event.currentTarget.checked })}
          />
          <span>Left out for now</span>
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
          <TrashIcon /> Remove the stop
        </button>
      </More>
    </div>
  );
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
        label="Question"
        texts={question.question}
        languages={languages}
        onDone={(text) => onChange(() => ({ question: text }))}
      />
      <WordFields
        label="Words to hear"
        words={question.words}
        languages={languages}
        onDone={(words) => onChange(() => ({ words }))}
      />
      <span class="tour-label">Answer</span>
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
      <Problems problems={problemsAt(tours.problems.value, path, [`${path}.answer`])} />
      <button type="button" class="button small quiet" onClick={props.onRemove}>
        <TrashIcon /> Remove the question
      </button>
    </div>
  );
}

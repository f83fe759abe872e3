/** The tour that is edited: what became of the edits, its way, its stops, and all that is the tour's as a whole. */

import { useSignal } from "@preact/signals";
import { plural, t } from "../i18n";
import { Confirm } from "../map/Confirm";
import { useApp } from "../state/context";
import { TrashIcon } from "../ui/icons";
import { FigureField, More, Problems, TextFields, WordFields } from "./parts";
import { RehearsalCard } from "./RehearsalCard";
import { StepList } from "./StepList";
import { StopAdders } from "./StopAdders";
import { StopList } from "./StopList";
import { ConflictNote, TourHead } from "./TourHead";
import { SETTINGS, Settings } from "./TourSettings";
import { textOf } from "./tourEdits";
import { problemsAt, problemsOfTour } from "./tourProblems";
import { tourWords } from "./tourRoute";

export function TourEditor() {
  const { tours } = useApp();
  const tour = tours.draft.value!;
  return (
    <section
      class="card tour-editor"
      aria-label={t("Tour {title}", { title: textOf(tour.title, tour.languages) })}
      data-testid="tour-editor"
      data-id={tour.id}
    >
      <TourHead />
      <ConflictNote />
      <Problems problems={problemsOfTour(tours.problems.value, SETTINGS)} />
      <Way />
      <RehearsalCard />
      <StopList />
      <StopAdders />
      <Settings />
      <Greeting />
      <Farewell />
      <Files />
    </section>
  );
}

function Way() {
  const { tours, tourRoute } = useApp();
  const tour = tours.draft.value!;
  const legs = tourRoute.legs.value;
  const lack = tourRoute.lack.value;
  if (lack)
    return (
      <p class="tour-way warn" data-testid="tour-way" data-state="none">
        {lack}
      </p>
    );
  if (legs.length === 0) return null;
  const { text, blocked } = tourWords(tour, legs);
  return (
    <p
      class={`tour-way ${blocked > 0 ? "bad" : ""}`}
      role="status"
      data-testid="tour-way"
      data-state={blocked > 0 ? "blocked" : "way"}
    >
      {text}
      {blocked > 0 && <b>{plural(blocked, ". {count} leg cannot be driven.", ". {count} legs cannot be driven.")}</b>}
      {tourRoute.planning.value && <span class="muted"> …</span>}
    </p>
  );
}

function Greeting() {
  const { tours } = useApp();
  const { greeting, languages } = tours.draft.value!;
  const { confirm } = greeting;
  const set = (change: Partial<typeof greeting>) =>
    void tours.edit((tour) => ({ ...tour, greeting: { ...tour.greeting, ...change } }));
  return (
    <More title={t("Greeting")} testid="tour-greeting" paths={["greeting"]}>
      <StepList
        path="greeting.do"
        steps={greeting.do}
        poster={null}
        onChange={(change) =>
          void tours.edit((tour) => ({ ...tour, greeting: { ...tour.greeting, do: change(tour.greeting.do) } }))
        }
      />
      <label class="check">
        <input
          type="checkbox"
          checked={confirm !== null}
          onChange={(event) =>
            set({
              confirm: event.currentTarget.checked
                ? { ask: { [languages[0] ?? "en"]: "Shall I show you round?" }, agree: {}, decline: {}, at_most_s: 20 }
                : null,
            })
          }
        />
        <span>{t("Asks before it leads")}</span>
      </label>
      {confirm && (
        <>
          <TextFields
            label={t("Question")}
            long
            texts={confirm.ask}
            languages={languages}
            path="greeting.confirm.ask"
            onDone={(ask) => set({ confirm: { ...confirm, ask } })}
          />
          <WordFields
            label={t("Words for yes")}
            words={confirm.agree}
            languages={languages}
            path="greeting.confirm.agree"
            placeholder={t("yes, yes please")}
            onDone={(agree) => set({ confirm: { ...confirm, agree } })}
          />
          <WordFields
            label={t("Words for no")}
            words={confirm.decline}
            languages={languages}
            path="greeting.confirm.decline"
            placeholder={t("no, no thanks")}
            onDone={(decline) => set({ confirm: { ...confirm, decline } })}
          />
          <FigureField
            label={t("No answer in so many seconds is a no")}
            value={confirm.at_most_s}
            path="greeting.confirm.at_most_s"
            testid="confirm-at-most"
            onDone={(at_most_s) => set({ confirm: { ...confirm, at_most_s } })}
          />
        </>
      )}
      <Problems
        problems={problemsAt(
          tours.problems.value,
          "greeting",
          confirm ? ["greeting.do", "greeting.confirm"] : ["greeting.do"],
        )}
      />
    </More>
  );
}

function Farewell() {
  const { tours } = useApp();
  const { farewell } = tours.draft.value!;
  return (
    <More title={t("Farewell")} testid="tour-farewell" paths={["farewell"]}>
      <StepList
        path="farewell.do"
        steps={farewell.do}
        poster={null}
        onChange={(change) => void tours.edit((tour) => ({ ...tour, farewell: { do: change(tour.farewell.do) } }))}
      />
    </More>
  );
}

/** Posters to print, the file, and the end of it all. */
function Files() {
  const { session, tours } = useApp();
  const asking = useSignal(false);
  const { id, stops } = tours.draft.value!;
  const shipped = tours.kept.value?.shipped ?? false;
  const posters = stops.some(({ poster }) => poster !== null);
  return (
    <div class="tour-files">
      {posters && (
        <>
          <a
            class="button small"
            href={session.tourRest.posters(id, "a4")}
            download={`${id}-a4.pdf`}
            data-testid="tour-posters"
          >
            {t("Posters, A4")}
          </a>
          <a class="button small" href={session.tourRest.posters(id, "letter")} download={`${id}-letter.pdf`}>
            {t("Posters, Letter")}
          </a>
        </>
      )}
      <a class="button small" href={session.tourRest.tourFile(id)} download={`${id}.yaml`} data-testid="tour-export">
        {t("File (YAML)")}
      </a>
      <a class="button small" href={session.tourRest.tourArchive(id)} download={`${id}.zip`} data-testid="tour-archive">
        {t("With pictures (ZIP)")}
      </a>
      {!shipped && (
        <button
          type="button"
          class="button small quiet"
          data-testid="tour-delete"
          onClick={() => (asking.value = true)}
        >
          <TrashIcon /> {t("Delete…")}
        </button>
      )}
      {asking.value && (
        <Confirm
          words={t("Delete this tour?")}
          yes={t("Delete")}
          onYes={() => {
            asking.value = false;
            void tours.remove();
          }}
          onNo={() => (asking.value = false)}
        />
      )}
    </div>
  );
}

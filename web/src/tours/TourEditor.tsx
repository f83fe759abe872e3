/** The tour that is edited: what became of the edits, its way, its stops, and all that is the tour's as a whole. */

import { useSignal } from "@preact/signals";
import { Confirm } from "../map/Confirm";
import { useApp } from "../state/context";
import { BackIcon, PlaceIcon, PlusIcon, TrashIcon, UndoIcon, WarnIcon } from "../ui/icons";
import { Choice, More, NumberField, Problems, TextFields, TypedField, WordFields } from "./parts";
import { RehearsalCard } from "./RehearsalCard";
import { StepList } from "./StepList";
import { StopList } from "./StopList";
import { stopOf, textOf } from "./tourEdits";
import { problemsAt, problemsOfTour } from "./tourProblems";
import { tourWords } from "./tourRoute";

export function TourEditor() {
  const { tours } = useApp();
  const tour = tours.draft.value!;
  return (
    <section
      class="card tour-editor"
      aria-label={`Tour ${textOf(tour.title, tour.languages)}`}
      data-testid="tour-editor"
      data-id={tour.id}
    >
      <Head />
      <ConflictNote />
      <Problems problems={problemsOfTour(tours.problems.value)} />
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

function Head() {
  const { stops, tours } = useApp();
  const tour = tours.draft.value!;
  const kept = tours.kept.value;
  const state = tours.conflict.value
    ? "Not kept"
    : tours.busy.value
      ? "Saving…"
      : tours.unsaved.value
        ? "Not kept"
        : "Kept";
  return (
    <>
      <h2 class="card-head tour-head">
        <button
          type="button"
          class="icon-button"
          data-testid="tour-close"
          aria-label="All tours"
          title="All tours"
          onClick={() => {
            stops.open.value = null;
            tours.close();
            void tours.refresh();
          }}
        >
          <BackIcon />
        </button>
        <span class="tour-name">{textOf(tour.title, tour.languages)}</span>
        <span class={`tour-state small ${state === "Not kept" ? "bad" : ""}`} role="status" data-testid="tour-state">
          {state}
        </span>
        <button
          type="button"
          class="icon-button"
          data-testid="tour-undo"
          aria-label="Undo"
          title="Undo the last change of this tour, anyone's"
          disabled={!kept?.can_undo || tours.busy.value}
          onClick={() => void tours.undo("undo")}
        >
          <UndoIcon />
        </button>
        <button
          type="button"
          class="icon-button mirrored"
          data-testid="tour-redo"
          aria-label="Redo"
          title="Redo"
          disabled={!kept?.can_redo || tours.busy.value}
          onClick={() => void tours.undo("redo")}
        >
          <UndoIcon />
        </button>
      </h2>
      {tours.refusal.value && (
        <p class="inline-note error" role="alert" data-testid="tour-refusal">
          <WarnIcon />
          <span>{tours.refusal.value}</span>
          {tours.unsaved.value && (
            <button type="button" class="button small" onClick={() => void tours.save()}>
              Again
            </button>
          )}
        </p>
      )}
    </>
  );
}

/** Another editor changed the same. */
function ConflictNote() {
  const { tours } = useApp();
  const conflict = tours.conflict.value;
  if (!conflict) return null;
  return (
    <div class="inline-note error stacked" role="alert" data-testid="tour-conflict">
      <b>Another editor has changed the same: {conflict.paths.join(", ")}.</b>
      <span>What only one of you has changed is kept in any case.</span>
      <span class="form-actions">
        <button type="button" class="button small" data-testid="tour-mine" onClick={() => void tours.decide("mine")}>
          Keep mine
        </button>
        <button
          type="button"
          class="button small"
          data-testid="tour-theirs"
          onClick={() => void tours.decide("theirs")}
        >
          Take theirs
        </button>
      </span>
    </div>
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
      {blocked > 0 && <b>{blocked === 1 ? ". 1 leg cannot be driven." : `. ${blocked} legs cannot be driven.`}</b>}
      {tourRoute.planning.value && <span class="muted"> …</span>}
    </p>
  );
}

/** Makes stops: where the robot is, before found posters, at places of the map. */
function StopAdders() {
  const { places, stops, store, tours } = useApp();
  const tour = tours.draft.value!;
  const posters = (store.of("landmarks").value?.landmarks ?? []).filter((one) => !stopOf(tour, one));
  const free = places.all.value.filter(({ id }) => !tour.stops.some(({ place }) => place === id));
  const known = store.of("localization").value !== null;
  const allowed = tours.allowed.value;
  return (
    <div class="tour-adders" role="group" aria-label="Add a stop">
      <button
        type="button"
        class="button small"
        data-testid="stop-here"
        title="A stop where the robot is now"
        disabled={!allowed || !known}
        onClick={() => void stops.here()}
      >
        <PlaceIcon /> Here
      </button>
      {posters.map((poster) => (
        <button
          key={`${poster.text}@${poster.id}`}
          type="button"
          class="button small"
          data-testid="stop-poster"
          data-text={poster.text}
          title={stops.lack(poster) || `A stop before the poster ${poster.text}`}
          disabled={!allowed || stops.lack(poster) !== ""}
          onClick={() => void stops.fromPoster(poster)}
        >
          <PlusIcon /> {poster.text.length > 26 ? `${poster.text.slice(0, 25)}…` : poster.text}
        </button>
      ))}
      {free.length > 0 && (
        <select
          aria-label="A stop at a place of the map"
          data-testid="stop-place"
          value=""
          disabled={!allowed}
          onChange={(event) => {
            const place = free.find(({ id }) => id === event.currentTarget.value);
            event.currentTarget.value = "";
            if (place) void stops.at(place);
          }}
        >
          <option value="">At a place…</option>
          {free.map(({ id, name }) => (
            <option key={id} value={id}>
              {name}
            </option>
          ))}
        </select>
      )}
    </div>
  );
}

function Settings() {
  const { maps, places, tours } = useApp();
  const tour = tours.draft.value!;
  const { languages, pace } = tour;
  const inUse = maps.inUse.value ?? "";
  const known = places.all.value;
  const homes = [["", "nowhere: it stays at the end"], ...known.map(({ id, name }) => [id, name])] as [
    string,
    string,
  ][];
  if (tour.home !== null && !known.some(({ id }) => id === tour.home)) homes.push([tour.home, tour.home]);
  const set = (change: Partial<typeof tour>) => void tours.edit((before) => ({ ...before, ...change }));
  return (
    <More title="Title, languages, pace" testid="tour-settings">
      <TextFields
        label="Title"
        texts={tour.title}
        languages={languages}
        testid="tour-title"
        onDone={(title) => set({ title })}
      />
      <TypedField
        label="Languages"
        value={languages.join(", ")}
        testid="tour-languages"
        hint="The first is in every text: en, fr"
        onDone={(typed) =>
          set({
            languages: typed
              .split(/[\s,]+/)
              .filter((tag) => tag !== "")
              .map((tag) => tag.toLowerCase()),
          })
        }
      />
      <Choice
        label="Map"
        value={tour.map}
        options={[...new Set([tour.map, inUse].filter((name) => name !== ""))].map((name) => [name, name] as const)}
        onChange={(map) => set({ map })}
      />
      <Choice
        label="Afterwards it goes to"
        value={tour.home ?? ""}
        testid="tour-home"
        options={homes}
        onChange={(home) => set({ home: home || null })}
      />
      <div class="form-row">
        <NumberField
          label="Speed (share)"
          value={pace.speed}
          testid="tour-speed"
          onDone={(speed) => speed !== null && set({ pace: { ...pace, speed } })}
        />
        <NumberField
          label="Waits behind (m)"
          value={pace.wait_m}
          onDone={(wait_m) => wait_m !== null && set({ pace: { ...pace, wait_m } })}
        />
        <NumberField
          label="Gives up (s)"
          value={pace.give_up_s}
          onDone={(give_up_s) => give_up_s !== null && set({ pace: { ...pace, give_up_s } })}
        />
      </div>
      <Choice
        label="A stop that cannot be reached"
        value={tour.on_failure.reach.then}
        options={[
          ["skip", "is left out"],
          ["present_from_here", "is presented from where the robot is"],
          ["end", "ends the tour"],
        ]}
        onChange={(then) => set({ on_failure: { ...tour.on_failure, reach: { ...tour.on_failure.reach, then } } })}
      />
    </More>
  );
}

function Greeting() {
  const { tours } = useApp();
  const { greeting, languages } = tours.draft.value!;
  const { confirm } = greeting;
  const set = (change: Partial<typeof greeting>) =>
    void tours.edit((tour) => ({ ...tour, greeting: { ...tour.greeting, ...change } }));
  return (
    <More title="Greeting">
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
        <span>Asks before it leads</span>
      </label>
      {confirm && (
        <>
          <TextFields
            label="Question"
            long
            texts={confirm.ask}
            languages={languages}
            onDone={(ask) => set({ confirm: { ...confirm, ask } })}
          />
          <WordFields
            label="Yes"
            words={confirm.agree}
            languages={languages}
            onDone={(agree) => set({ confirm: { ...confirm, agree } })}
          />
          <WordFields
            label="No"
            words={confirm.decline}
            languages={languages}
            onDone={(decline) => set({ confirm: { ...confirm, decline } })}
          />
        </>
      )}
      <Problems problems={problemsAt(tours.problems.value, "greeting", ["greeting.do"])} />
    </More>
  );
}

function Farewell() {
  const { tours } = useApp();
  const { farewell } = tours.draft.value!;
  return (
    <More title="Farewell">
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
            href={session.rest.posters(id, "a4")}
            download={`${id}-a4.pdf`}
            data-testid="tour-posters"
          >
            Posters, A4
          </a>
          <a class="button small" href={session.rest.posters(id, "letter")} download={`${id}-letter.pdf`}>
            Posters, Letter
          </a>
        </>
      )}
      <a class="button small" href={session.rest.tourFile(id)} download={`${id}.yaml`} data-testid="tour-export">
        File (YAML)
      </a>
      {!shipped && (
        <button
          type="button"
          class="button small quiet"
          data-testid="tour-delete"
          onClick={() => (asking.value = true)}
        >
          <TrashIcon /> Delete…
        </button>
      )}
      {asking.value && (
        <Confirm
          words="Delete this tour?"
          yes="Delete"
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

/** What is the tour's as a whole: its title and languages, how it leads, which codes it obeys. */

import { type Text, t } from "../i18n";
import type { Commands, Pace, Tour } from "../protocol/types";
import { useApp } from "../state/context";
import { FailureFields } from "./FailureFields";
import { Choice, FigureField, More, TextFields, TypedField, WordFields } from "./parts";
import { BeginSettings } from "./TourBegin";
import { linesOf } from "./tourRules";

/** Those of a tour's problems that have a field here. */
export const SETTINGS = [
  "title",
  "languages",
  "map",
  "home",
  "begin",
  "schedule",
  "battery",
  "pace",
  "on_failure",
  "commands",
  "accept",
] as const;

export function Settings() {
  return (
    <>
      <Basics />
      <BeginSettings />
      <Leading />
      <Failing />
      <Spoken />
      <Accepting />
    </>
  );
}

function Basics() {
  const { maps, places, tours } = useApp();
  const tour = tours.draft.value!;
  const { languages } = tour;
  const known = places.all.value;
  const homes: [string, string][] = [
    ["", t("nowhere: it stays at the end")],
    ...known.map(({ id, name }): [string, string] => [id, name]),
  ];
  if (tour.home !== null && !known.some(({ id }) => id === tour.home))
    homes.push([tour.home, t("{home} (not on this map)", { home: tour.home })]);
  const names = [tour.map, maps.inUse.value ?? "", ...(maps.list.value?.maps ?? []).map(({ name }) => name)];
  const set = (change: Partial<Tour>) => void tours.edit((before) => ({ ...before, ...change }));
  return (
    <More title={t("Title, languages, map")} testid="tour-settings" paths={["title", "languages", "map", "home"]}>
      <TextFields
        label={t("Title")}
        texts={tour.title}
        languages={languages}
        path="title"
        testid="tour-title"
        onDone={(title) => set({ title })}
      />
      <TypedField
        label={t("Languages")}
        value={languages.join(", ")}
        path="languages"
        testid="tour-languages"
        hint={t("Short names, as en, fr. Every text has the first; of the others, some may be missing.")}
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
        label={t("Map")}
        value={tour.map}
        path="map"
        options={[...new Set(names.filter((name) => name !== ""))].map((name) => [name, name] as const)}
        onChange={(map) => set({ map })}
      />
      <Choice
        label={t("Afterwards it goes to")}
        value={tour.home ?? ""}
        path="home"
        testid="tour-home"
        options={homes}
        onChange={(home) => set({ home: home || null })}
      />
    </More>
  );
}

function Leading() {
  const { tours } = useApp();
  const { pace } = tours.draft.value!;
  const set = (change: Partial<Pace>) =>
    void tours.edit((before) => ({ ...before, pace: { ...before.pace, ...change } }));
  return (
    <More
      title={t("Pace")}
      testid="tour-pace"
      paths={["pace"]}
      about={t("{share} % of its speed", { share: Math.round(pace.speed * 100) })}
    >
      <FigureField
        label={t("Speed (% of its greatest)")}
        value={pace.speed}
        scale={100}
        range={[1, 100]}
        path="pace.speed"
        testid="tour-speed"
        onDone={(speed) => set({ speed })}
      />
      <div class="form-row">
        <FigureField
          label={t("Slows down behind (m)")}
          value={pace.slow_m}
          path="pace.slow_m"
          testid="tour-slow"
          onDone={(slow_m) => set({ slow_m })}
        />
        <FigureField
          label={t("Waits behind (m)")}
          value={pace.wait_m}
          path="pace.wait_m"
          testid="tour-wait"
          onDone={(wait_m) => set({ wait_m })}
        />
        <FigureField
          label={t("Waits at most (s)")}
          value={pace.give_up_s}
          path="pace.give_up_s"
          onDone={(give_up_s) => set({ give_up_s })}
        />
      </div>
      <p class="field-hint">
        {t("So far behind visitors may be. After the wait it goes on with those who are there, or ends.")}
      </p>
      <FigureField
        label={t("Looks back every (m)")}
        value={pace.look_back_m}
        path="pace.look_back_m"
        testid="tour-look-back"
        hint={t("It stops and turns, for its cameras see only ahead.")}
        onDone={(look_back_m) => set({ look_back_m })}
      />
    </More>
  );
}

function Failing() {
  const { tours } = useApp();
  const { on_failure } = tours.draft.value!;
  return (
    <More title={t("When something fails")} testid="tour-failure" paths={["on_failure"]}>
      <FailureFields
        path="on_failure"
        rules={on_failure}
        onReach={(change) =>
          void tours.edit((before) => ({
            ...before,
            on_failure: { ...before.on_failure, reach: { ...before.on_failure.reach, ...change } },
          }))
        }
        onPresent={(change) =>
          void tours.edit((before) => ({
            ...before,
            on_failure: { ...before.on_failure, present: { ...before.on_failure.present, ...change } },
          }))
        }
      />
    </More>
  );
}

const COMMANDS: readonly [keyof Commands, Text, string][] = [
  ["pause", "Pause", "wait please"],
  ["resume", "Go on after such a pause", "go on"],
  ["skip", "Skip the stop", "skip this"],
  ["undo_skip", "Back to the skipped stop", "go back"],
  ["repeat", "Repeat the stop", "once more"],
  ["end", "End the tour", "stop the tour"],
];

function Spoken() {
  const { tours } = useApp();
  const { commands, languages } = tours.draft.value!;
  const used = COMMANDS.filter(([name]) => Object.keys(commands[name]).length > 0).length;
  return (
    <More
      title={t("Words that steer it")}
      testid="tour-commands"
      paths={["commands"]}
      about={used === 0 ? t("none") : String(used)}
    >
      <p class="field-hint">{t("What visitors may say, with commas between. Without a word, only buttons do it.")}</p>
      {COMMANDS.map(([name, label, placeholder]) => (
        <WordFields
          key={name}
          label={t(label)}
          words={commands[name]}
          languages={languages}
          path={`commands.${name}`}
          placeholder={placeholder}
          onDone={(words) =>
            void tours.edit((before) => ({ ...before, commands: { ...before.commands, [name]: words } }))
          }
        />
      ))}
      <p class="field-hint">{t("A pause by the operator, and one after the emergency stop, end only with a press.")}</p>
    </More>
  );
}

function Accepting() {
  const { tours } = useApp();
  const { accept } = tours.draft.value!;
  return (
    <More
      title={t("Further codes")}
      testid="tour-accept"
      paths={["accept"]}
      about={accept.length === 0 ? t("none") : String(accept.length)}
    >
      <TypedField
        label={t("Texts of codes to obey")}
        long
        value={accept.join("\n")}
        path="accept"
        testid="tour-accept-texts"
        placeholder="HBBA:SAY/EN/MIND THE STEP."
        hint={t("One a line, beside the posters of the stops. Any other code is shown as text, and does nothing.")}
        onDone={(typed) => void tours.edit((before) => ({ ...before, accept: linesOf(typed) }))}
      />
    </More>
  );
}

/** What begins a tour: visitors, or the clock; and how much charge it needs. */

import { rich, t, within } from "../i18n";
import type { BatteryRule, Begin, Slot } from "../protocol/types";
import { useApp } from "../state/context";
import { PlusIcon, TrashIcon } from "../ui/icons";
import { FigureField, More, Problems, Several, TypedField } from "./parts";
import { problemsAt } from "./tourProblems";
import { chosen, DAYS, NEW_SLOT, slotWords, timesOf } from "./tourRules";

const BY = [
  ["press", "A press"],
  ["face", "A face"],
  ["voice", "A voice"],
] as const;

export function BeginSettings() {
  return (
    <>
      <Visitors />
      <Schedule />
      <Battery />
    </>
  );
}

function Visitors() {
  const { tours } = useApp();
  const { begin } = tours.draft.value!;
  const edit = (change: (now: Begin) => Partial<Begin>) =>
    void tours.edit((before) => ({ ...before, begin: { ...before.begin, ...change(before.begin) } }));
  const set = (change: Partial<Begin>) => edit(() => change);
  const words = BY.filter(([by]) => begin.by.includes(by)).map(([, name]) => within(t(name)));
  return (
    <More title={t("Who begins it")} testid="tour-begin" paths={["begin"]} about={words.join(", ")}>
      <Several
        label={t("It begins by")}
        values={begin.by}
        options={BY.map(([by, name]) => [by, t(name)] as const)}
        path="begin.by"
        testid="tour-begin-by"
        onChange={(by, on) =>
          edit((now) => ({
            by: chosen(
              BY.map(([each]) => each),
              now.by,
              by,
              on,
            ),
          }))
        }
      />
      <div class="form-row">
        <FigureField
          label={t("People at least")}
          value={begin.people_min}
          path="begin.people_min"
          testid="tour-people-min"
          onDone={(people_min) => set({ people_min })}
        />
        <FigureField
          label={t("Within (m)")}
          value={begin.within_m}
          path="begin.within_m"
          onDone={(within_m) => set({ within_m })}
        />
        <FigureField label={t("For (s)")} value={begin.for_s} path="begin.for_s" onDone={(for_s) => set({ for_s })} />
      </div>
      <p class="field-hint">
        {rich(
          "A press on the page, or on a visitor's phone. A face or a voice counts if so many people are so near for so long. It needs {button}.",
          { button: <i>{t("Wait for visitors")}</i> },
        )}
      </p>
    </More>
  );
}

function Schedule() {
  const { tours } = useApp();
  const { schedule } = tours.draft.value!;
  const edit = (change: (slots: readonly Slot[]) => Slot[]) =>
    void tours.edit((before) => ({ ...before, schedule: change(before.schedule) }));
  const parts = schedule.map((_, at) => `schedule.${at}`);
  return (
    <More
      title={t("Schedule")}
      testid="tour-schedule"
      paths={["schedule"]}
      about={schedule.map(slotWords).join("; ") || t("none")}
    >
      {schedule.map((slot, at) => (
        // A slot has no id: it is what is at its place in the list.
        <SlotFields
          key={`slot ${at}`}
          slot={slot}
          path={`schedule.${at}`}
          onChange={(change) =>
            edit((slots) => slots.map((each, number) => (number === at ? { ...each, ...change(each) } : each)))
          }
          onRemove={() => edit((slots) => slots.toSpliced(at, 1))}
        />
      ))}
      <Problems problems={problemsAt(tours.problems.value, "schedule", parts)} />
      <button
        type="button"
        class="button small quiet"
        data-testid="schedule-add"
        onClick={() => edit((slots) => [...slots, NEW_SLOT])}
      >
        <PlusIcon /> {t("Days and times")}
      </button>
      <p class="field-hint">
        {rich("It begins by itself then, by the robot's clock, while it is set to {button}.", {
          button: <i>{t("Wait for visitors")}</i>,
        })}
      </p>
    </More>
  );
}

function SlotFields(props: {
  slot: Slot;
  path: string;
  onChange: (change: (now: Slot) => Partial<Slot>) => void;
  onRemove: () => void;
}) {
  const { slot, path, onChange } = props;
  const { tours } = useApp();
  return (
    <div class="tour-question" role="group" aria-label={slotWords(slot)} data-testid="schedule-slot">
      <Several
        label={t("Days")}
        values={slot.days}
        options={DAYS.map(([day, name]) => [day, t(name)] as const)}
        letters={2}
        path={`${path}.days`}
        testid="schedule-day"
        onChange={(day, on) =>
          onChange((now) => ({
            days: chosen(
              DAYS.map(([each]) => each),
              now.days,
              day,
              on,
            ),
          }))
        }
      />
      <TypedField
        label={t("Times")}
        value={slot.times.join(", ")}
        path={`${path}.times`}
        testid="schedule-times"
        placeholder="10:00, 14:30"
        onDone={(typed) => onChange(() => ({ times: timesOf(typed) }))}
      />
      <Problems problems={problemsAt(tours.problems.value, path, [`${path}.days`, `${path}.times`])} />
      <button type="button" class="button small quiet" data-testid="schedule-remove" onClick={props.onRemove}>
        <TrashIcon /> {t("Remove these times")}
      </button>
    </div>
  );
}

function Battery() {
  const { tours } = useApp();
  const { battery } = tours.draft.value!;
  const set = (change: Partial<BatteryRule>) =>
    void tours.edit((before) => ({ ...before, battery: { ...before.battery, ...change } }));
  const percent = (share: number) => `${Math.round(share * 100)} %`;
  return (
    <More
      title={t("Battery")}
      testid="tour-battery"
      paths={["battery"]}
      about={t("at least {beginMin} to begin", { beginMin: percent(battery.begin_min) })}
    >
      <div class="form-row two">
        <FigureField
          label={t("At least, to begin (%)")}
          value={battery.begin_min}
          scale={100}
          range={[0, 100]}
          path="battery.begin_min"
          testid="battery-begin"
          onDone={(begin_min) => set({ begin_min })}
        />
        <FigureField
          label={t("Ends the tour below (%)")}
          value={battery.end_below}
          scale={100}
          range={[0, 100]}
          path="battery.end_below"
          testid="battery-end"
          onDone={(end_below) => set({ end_below })}
        />
      </div>
    </More>
  );
}

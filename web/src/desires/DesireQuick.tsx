/** The way to one more desire: presets of one press, and the form, which is loaded when it is asked for. */

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import { idempotencyKey } from "../protocol/requests";
import { useApp } from "../state/context";
import { spaced } from "../ui/format";
import { PlusIcon } from "../ui/icons";
import { later } from "../ui/later";
import { type Quick, quick } from "./quick";
import { offered } from "./schema";

const Form = later(async () => (await import("./DesireForm")).DesireForm);

export function DesireQuick() {
  const open = useSignal(false);
  const { store } = useApp();
  // What nothing here serves is no choice: a recording is not recorded.
  const classes = offered(store.hello.value?.classes ?? []);
  const add = useRef<HTMLButtonElement>(null);
  if (open.value) {
    const close = () => {
      open.value = false;
      requestAnimationFrame(() => add.current?.focus());
    };
    return <Form classes={classes} onClose={close} />;
  }
  const scale = store.hello.value?.scale ?? { intensity: 8, utility: 8 };
  return (
    <div class="desire-quick">
      <button
        type="button"
        ref={add}
        class="button"
        data-testid="desire-add"
        disabled={classes.length === 0}
        onClick={() => (open.value = true)}
      >
        <PlusIcon /> {t("Add a desire")}
      </button>
      {quick(classes, scale).map((one) => (
        <QuickButton key={one.title} one={one} />
      ))}
    </div>
  );
}

function QuickButton({ one }: { one: Quick }) {
  const { session, store } = useApp();
  const busy = useSignal(false);
  const add = async () => {
    busy.value = true;
    try {
      await session.rest.addDesire(one.desire, idempotencyKey());
      store.notify("info", t("Added a desire: {title}.", { title: one.title }));
    } catch (error) {
      store.notify("error", `${one.title}: ${inWords(error)}`);
    } finally {
      busy.value = false;
    }
  };
  return (
    <button
      type="button"
      class="kind"
      data-testid={`quick-${one.desire.class}`}
      disabled={busy.value}
      title={t("Adds a desire for {class} that lasts {ttl} s", {
        class: spaced(one.desire.class),
        ttl: one.desire.ttl,
      })}
      onClick={() => void add()}
    >
      {one.title}
    </button>
  );
}

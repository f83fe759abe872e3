/** A part of the page that is loaded when it is first shown: what most visitors never open costs them nothing. */

import { signal } from "@preact/signals";
import type { ComponentChildren, FunctionComponent } from "preact";
import { useEffect } from "preact/hooks";
import { t } from "../i18n";

/** What `load` brings, once it is there; until then, that it is on its way, or how to ask again. */
export function later<P extends object>(load: () => Promise<(props: P) => ComponentChildren>): FunctionComponent<P> {
  const part = signal<FunctionComponent<P> | null>(null);
  const failed = signal(false);
  const ask = () => {
    failed.value = false;
    load().then(
      (loaded) => {
        part.value = loaded as FunctionComponent<P>;
      },
      () => {
        failed.value = true;
      },
    );
  };
  return function Later(props: P) {
    useEffect(() => {
      if (!part.peek()) ask();
    }, []);
    const Part = part.value;
    if (Part) return <Part {...props} />;
    return failed.value ? (
      <p class="later muted" role="alert" data-testid="not-loaded">
        {t("This part of the page did not load.")}{" "}
        <button type="button" class="link-button" data-testid="load-again" onClick={ask}>
          {t("Try again")}
        </button>
      </p>
    ) : (
      <p class="later muted" role="status">
        {t("Loading…")}
      </p>
    );
  };
}

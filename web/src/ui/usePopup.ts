/** A box that a button opens over the page, closed by Escape, by a press elsewhere, and by the button itself. */

import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { useApp } from "../state/context";

interface Popup {
  open: Signal<boolean>;
  button: RefObject<HTMLButtonElement | null>;
  box: RefObject<HTMLDivElement | null>;
  /** Closes it and gives the button the focus back. */
  close: () => void;
}

/** `first`: selector of what in the box has the focus when it opens. */
export function usePopup(first = ""): Popup {
  const { store } = useApp();
  const open = useSignal(false);
  const button = useRef<HTMLButtonElement>(null);
  const box = useRef<HTMLDivElement>(null);
  const close = () => {
    open.value = false;
    button.current?.focus();
  };
  useLayoutEffect(() => {
    if (!open.value) return;
    if (first) box.current?.querySelector<HTMLElement>(first)?.focus();
    const away = (event: Event) => {
      const inside = [box, button].some(({ current }) => current?.contains(event.target as Node));
      if (!inside) open.value = false;
    };
    document.addEventListener("pointerdown", away);
    const closed = store.opened(close);
    return () => {
      document.removeEventListener("pointerdown", away);
      closed();
    };
  }, [open.value]);
  return { open, button, box, close };
}

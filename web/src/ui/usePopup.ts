/** A box that a button opens over the page, closed by Escape, by a press elsewhere, and by the button itself. */

import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
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
  useEffect(() => {
    if (!open.value) return;
    if (first) box.current?.querySelector<HTMLElement>(first)?.focus();
    const away = (event: Event) => {
      const inside = [box, button].some(({ current }) => current?.contains(event.target as Node));
      if (!inside) open.value = false;
    };
    document.addEventListener("pointerdown", away);
    store.popup.value = close;
    return () => {
      document.removeEventListener("pointerdown", away);
      if (store.popup.peek() === close) store.popup.value = null;
    };
  }, [open.value]);
  return { open, button, box, close };
}

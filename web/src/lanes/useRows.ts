/** The lanes' present values, at a pace that people read: four times a second at most, and only when they differ. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { LaneRow } from "../protocol/types";
import { useApp } from "../state/context";
import { sameRows } from "./rows";

const EVERY_MS = 250;

export function useRows(): readonly LaneRow[] {
  const { store } = useApp();
  const rows = useSignal<LaneRow[]>(store.rows.peek());
  useEffect(() => {
    const timer = window.setInterval(() => {
      const next = store.rows.peek();
      if (!sameRows(rows.peek(), next)) rows.value = next;
    }, EVERY_MS);
    return () => clearInterval(timer);
  }, []);
  return rows.value;
}

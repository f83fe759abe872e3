/** The lanes' present values, at a pace that people read: four times a second at most, and only when they differ. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { LaneRow } from "../protocol/types";
import { useApp } from "../state/context";
import { fourTimesASecond } from "../state/turns";
import { sameRows } from "./rows";

export function useRows(): readonly LaneRow[] {
  const { store } = useApp();
  const rows = useSignal<LaneRow[]>(store.rows.peek());
  useEffect(() => {
    return fourTimesASecond(() => {
      const next = store.rows.peek();
      if (!sameRows(rows.peek(), next)) rows.value = next;
    });
  }, []);
  return rows.value;
}

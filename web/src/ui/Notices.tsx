/** Notices to this viewer: short, dismissable, gone by themselves; where they cover no control. */

import { useLayoutEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { CloseIcon, WarnIcon } from "./icons";
import { type Box, covers, type Obstacle, placed, type Size } from "./noticePlace";

const WIDTHS = [560, 420, 300, 200];
const MARGIN = 8;
/** While notices are shown, what is below them may change. */
const AGAIN_MS = 250;

/** What must not be covered, and how much less each is: what moves or stops the robot, what can be pressed, what is read. */
const WEIGHTS: readonly (readonly [selector: string, weight: number])[] = [
  [".estop-group, .drive-pad, .dock, .estop-ask, .drive-settings, .banner", 100],
  ["button, a[href], input, select, textarea, summary, [role=separator]", 10],
  [".viewpoints, .view-tools, .camera-tools, .scene-picked, .tour-picked, .tour-drive, .tab-list, .sheet", 5],
  ["[data-testid=guard-state], [data-testid=connection], .subtitles, .tab-panel", 0.5], // a panel is scrolled, too
  [".caution, .insets > .inset", 0.05],
  [".lanes, .top-bar", 0.02],
];
/** What is scrolled out of these is not on the screen. */
const SCROLLED = ".tab-panel, .tab-list, .lanes-body, .sheet, .drive-side";

function obstacles(): Obstacle[] {
  const found: Obstacle[] = [];
  for (const [selector, weight] of WEIGHTS)
    for (const each of document.querySelectorAll(selector)) {
      if (each.closest(".notices, .skips")) continue;
      const box = each.getBoundingClientRect();
      const clip = each.parentElement?.closest(SCROLLED)?.getBoundingClientRect();
      const left = Math.max(box.left, clip?.left ?? 0);
      const top = Math.max(box.top, clip?.top ?? 0);
      const width = Math.min(box.right, clip?.right ?? innerWidth) - left;
      const height = Math.min(box.bottom, clip?.bottom ?? innerHeight) - top;
      if (width > 0 && height > 0) found.push({ left, top, width, height, weight });
    }
  return found;
}

/** Its size at each width that the window has room for. */
function sizes(notice: HTMLElement): Size[] {
  const widths = [...new Set(WIDTHS.map((width) => Math.min(width, innerWidth - 2 * MARGIN)))];
  return widths.map((width) => {
    notice.style.maxWidth = `${width}px`;
    const { width: wide, height } = notice.getBoundingClientRect();
    return { width: Math.ceil(wide), height };
  });
}

/** Each is kept where it is while that is free; the older ones have the first choice. */
function place(list: HTMLElement, kept: WeakMap<Element, Box>): void {
  const taken = obstacles();
  const view = document.querySelector(".page > .view")?.getBoundingClientRect();
  const bar = document.querySelector(".top-bar")?.getBoundingClientRect().bottom ?? 0;
  const seen = view && view.width > 0;
  const wanted = { x: seen ? view.left + view.width / 2 : innerWidth / 2, y: (seen ? view.top : bar) + 12 };
  const room = { left: MARGIN, top: MARGIN, width: innerWidth - 2 * MARGIN, height: innerHeight - 2 * MARGIN };
  for (const notice of list.children as Iterable<HTMLElement>) {
    let box = kept.get(notice);
    const still = box && box.left + box.width <= innerWidth && box.top + box.height <= innerHeight;
    if (!box || !still || covers(box, taken) > 0) {
      notice.style.left = notice.style.top = "0";
      box = placed(sizes(notice), room, wanted, taken);
      kept.set(notice, box);
      notice.style.maxWidth = `${box.width}px`;
      notice.style.left = `${box.left}px`;
      notice.style.top = `${box.top}px`;
    }
    taken.push({ ...box, weight: 10 });
  }
}

export function Notices() {
  const { store } = useApp();
  const list = useRef<HTMLDivElement>(null);
  const kept = useRef(new WeakMap<Element, Box>());
  const notices = store.notices.value;
  useLayoutEffect(() => {
    if (notices.length === 0) return;
    const again = () => place(list.current!, kept.current);
    again();
    const timer = setInterval(again, AGAIN_MS);
    window.addEventListener("resize", again);
    return () => {
      clearInterval(timer);
      window.removeEventListener("resize", again);
    };
  }, [notices]);
  return (
    <div class="notices" role="log" aria-live="polite" aria-label={t("Notices")} ref={list}>
      {notices.map((notice) => (
        <div key={notice.id} class={`notice ${notice.level}`} data-testid="notice" data-level={notice.level}>
          {notice.level !== "info" && <WarnIcon />}
          <p lang={notice.lang}>{notice.text}</p>
          <button type="button" class="icon-button" aria-label={t("Dismiss")} onClick={() => store.dismiss(notice.id)}>
            <CloseIcon />
          </button>
        </div>
      ))}
    </div>
  );
}

/** Whether the page is narrow (a phone), or low (a phone held sideways), as signals. */

import { signal } from "@preact/signals";

const query = window.matchMedia("(max-width: 759px)");
export const narrow = signal(query.matches);
query.addEventListener("change", () => (narrow.value = query.matches));

const lowQuery = window.matchMedia("(min-width: 760px) and (max-height: 560px)");
/** Wide, but with no room below the view. */
export const low = signal(lowQuery.matches);
lowQuery.addEventListener("change", () => (low.value = lowQuery.matches));

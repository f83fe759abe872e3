/**
 * Whether the page is narrow (a phone), or low (a phone held sideways), as signals. Measured in the browser's own size of
 * text, as all widths that change the layout: a larger text is as much less room as a larger page.
 */

import { signal } from "@preact/signals";

const query = window.matchMedia("(max-width: 47.4375rem)");
export const narrow = signal(query.matches);
query.addEventListener("change", () => (narrow.value = query.matches));

const lowQuery = window.matchMedia("(min-width: 47.5rem) and (max-height: 35rem)");
/** Wide, but with no room below the view. */
export const low = signal(lowQuery.matches);
lowQuery.addEventListener("change", () => (low.value = lowQuery.matches));

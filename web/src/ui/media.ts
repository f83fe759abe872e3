/** Whether the page is narrow (a phone), as a signal. */

import { signal } from "@preact/signals";

const query = window.matchMedia("(max-width: 759px)");
export const narrow = signal(query.matches);
query.addEventListener("change", () => (narrow.value = query.matches));

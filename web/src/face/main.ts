/** The robot's face, for a screen of its own: drawn from the joints of the stream of the face, with subtitles. */

import { LiveConnection } from "../protocol/live";
import { Problem } from "../protocol/problem";
import { Requests } from "../protocol/requests";
import { Rest } from "../protocol/rest";
import { tokenIn } from "../protocol/token";
import type { FromRobot } from "../protocol/types";
import { subtitleOf } from "../speech/subtitle";
import type { Message } from "../state/latest";
import { codePath, QUIET } from "../ui/qrPath";
import { type Link, linkOf } from "./link";
import { FacePicture } from "./picture";
import { blended, CALM, type Pose, poseOf, same } from "./shape";
import "./face.css";

const WATCH_MS = 250;
/** The login is asked for on the console's page; this one looks again after so long. */
const AGAIN_MS = 5000;

const rest = new Rest(new Requests(() => "face"));
const picture = new FacePicture();
const subtitles = document.createElement("p");
subtitles.className = "subtitles";
subtitles.dataset["testid"] = "subtitles";
const code = document.createElement("div");
code.className = "visitor-code";
code.dataset["testid"] = "visitor-code";
document.body.append(picture.svg, subtitles, code);
document.body.insertAdjacentHTML(
  "beforeend",
  `<svg class="mark" viewBox="0 0 24 24" role="img" aria-label="No connection to the robot">
     <path d="M10 7l1.5-1.5a4.2 4.2 0 0 1 6 6L16 13M14 17l-1.5 1.5a4.2 4.2 0 0 1-6-6L8 11M5 5l14 14" /></svg>
   <p class="note" role="status"></p>`,
);

let target: Pose = CALM;
let shown: Pose = CALM;
let drawnAt = performance.now();
let open = false;
let newest: number | null = null;
let now: number | null = null;
let speech: Message<"speech"> | null = null;
let refused = false;

const live = new LiveConnection(
  () => {
    const address = new URL("./api/v1/face", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    address.hash = "";
    return address.href;
  },
  {
    opened: () => {
      open = true;
      newest = now = null;
      void keepScreenOn();
    },
    message: receive,
    binary: () => undefined,
    roundTrip: () => undefined,
    lost: (everOpened) => {
      open = false;
      watch();
      // A refused handshake looks like a robot that is off: ask which it is.
      if (!everOpened) void enter();
    },
  },
);

function receive(message: FromRobot): void {
  if (message.type === "face") {
    target = poseOf(message.joints);
    newest = message.stamp;
  } else if (message.type === "speech") speech = message;
  else if (message.type === "visitor_link") invite(message);
  else if (message.type === "pong") now = message.stamp;
  watch();
}

/** The way to the page for visitors, for their phones to read. */
function invite({ url, code: rows, problem }: Message<"visitor_link">): void {
  const shown = problem === "" ? url : "";
  if ((code.dataset["url"] ?? "") === shown) return;
  code.dataset["url"] = shown;
  const side = rows.length + 2 * QUIET;
  code.innerHTML = shown
    ? `<svg viewBox="0 0 ${side} ${side}" role="img" aria-label="Code for phones of visitors" shape-rendering="crispEdges">
         <rect width="${side}" height="${side}" fill="#fff" /><path d="${codePath(rows)}" /></svg>`
    : "";
}

function watch(): void {
  const link: Link = refused ? "login" : linkOf(open, newest, now);
  if (link !== "live") target = CALM;
  if (document.body.dataset["link"] !== link) {
    document.body.dataset["link"] = link;
    document.querySelector(".note")!.textContent = link === "login" ? "Log in at the console, on this screen" : "";
  }
  showSubtitles(link);
}

function showSubtitles(link: Link): void {
  const time = newest === null ? now : Math.max(newest, now ?? newest);
  const subtitle = link === "live" ? subtitleOf(speech, time) : null;
  const parts = subtitle ? [subtitle.before, subtitle.word, subtitle.after] : [];
  const text = parts.join("\u0000");
  if (subtitles.dataset["said"] === text) return;
  subtitles.dataset["said"] = text;
  subtitles.lang = speech?.language ?? "";
  subtitles.replaceChildren(...parts.map((part, place) => (place === 1 ? marked(part) : part)).filter(Boolean));
}

function marked(word: string): HTMLElement | string {
  if (!word) return "";
  const mark = document.createElement("mark");
  mark.textContent = word;
  return mark;
}

function animate(): void {
  const at = performance.now();
  const next = blended(shown, target, (at - drawnAt) / 1000);
  drawnAt = at;
  if (!same(next, shown) || !same(next, target)) {
    shown = next;
    picture.draw(shown);
  }
  requestAnimationFrame(animate);
}

/** A token in the address opens; without one, people log in at the console's page. */
async function enter(): Promise<void> {
  refused = await asked();
  const token = tokenIn(location.hash);
  if (refused && token !== null)
    refused = await rest.logIn(token).then(
      () => false,
      () => true,
    );
  watch();
  if (!refused) return;
  live.close();
  window.setTimeout(() => void enter().then(() => refused || live.open()), AGAIN_MS);
}

async function asked(): Promise<boolean> {
  try {
    await rest.session();
    return false;
  } catch (problem) {
    return problem instanceof Problem && problem.status === 401;
  }
}

/** Where the browser allows it: the screen of a robot that waits must not go dark. */
async function keepScreenOn(): Promise<void> {
  await navigator.wakeLock?.request("screen").catch(() => undefined);
}

picture.draw(shown);
watch();
window.setInterval(watch, WATCH_MS);
requestAnimationFrame(animate);
void enter().then(() => refused || live.open());

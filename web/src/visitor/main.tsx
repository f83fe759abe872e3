/** The page for visitors' phones: what the tour shows and says, and what it waits for. */

import { render } from "preact";
import { LiveConnection } from "../protocol/live";
import { Requests } from "../protocol/requests";
import { keyIn } from "../protocol/token";
import { VisitorRest } from "../protocol/visitorRest";
import { VisitorPage } from "./VisitorPage";
import { VisitorControl } from "./visitorControl";
import "./visitor.css";

const key = keyIn(location.hash);
// Not to be left in the history, nor in a link that is copied.
if (key !== null) history.replaceState(null, "", location.pathname);

function address(): string {
  const found = new URL("./api/v1/visitor/live", location.href);
  found.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  found.hash = "";
  return found.href;
}

const control = new VisitorControl(
  new VisitorRest(new Requests(() => "visitor")),
  key,
  (handlers) => new LiveConnection(address, handlers),
);
render(<VisitorPage control={control} />, document.body);
void control.enter();

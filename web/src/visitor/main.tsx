/** The page for visitors' phones: what the tour shows and says, and what it waits for. */

import { render } from "preact";
import { LiveConnection } from "../protocol/live";
import { Rest } from "../protocol/rest";
import { keyIn } from "../protocol/token";
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

const control = new VisitorControl(new Rest(() => "visitor"), key, (handlers) => new LiveConnection(address, handlers));
render(<VisitorPage control={control} />, document.body);
void control.enter();

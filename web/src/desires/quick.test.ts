import { expect, test } from "vitest";
import type { DesireClass } from "../protocol/types";
import { curl, quick } from "./quick";

const cls = (name: string, served = true) => ({ name, served }) as DesireClass;

test("only what the robot can serve is offered, in the middle of its scale and for a while", () => {
  const found = quick([cls("LocateVoices"), cls("LocateFaces", false), cls("Theirs")], { intensity: 8, utility: 8 });
  expect(found).toEqual([
    {
      title: "Listen for voices, 30 s",
      desire: { class: "LocateVoices", intensity: 8, utility: 4, security: false, params: {}, ttl: 30 },
    },
  ]);
});

/** What a POSIX shell makes of single-quoted pieces and escaped quotes. */
function unquoted(word: string): string {
  return word.replace(/'([^']*)'|\\(.)/g, (_, inside, escaped) => inside ?? escaped);
}

test("a shell reads the command as it was meant, quotes and all", () => {
  const desire = { class: "Say", params: { text: `It's "here" $HOME \\ ok` } };
  const command = curl("http://robot:8000/?scene=off", desire, false);
  const [head, body] = command.split(" -d ");
  expect(head).toBe("curl -X POST http://robot:8000/api/v1/desires -H 'Content-Type: application/json'");
  expect(JSON.parse(unquoted(body!))).toEqual(desire);
});

test("a locked console's command takes the token from the environment", () => {
  expect(curl("https://robot/", {}, true)).toContain('-H "Authorization: Bearer $HBBA_TOKEN"');
  expect(curl("https://robot/", {}, false)).not.toContain("Authorization");
});

/** The page on a visitor's phone: picture, subtitles, what can be pressed now; one column. */

import { useEffect, useRef } from "preact/hooks";
import type { VisitorView } from "../protocol/types";
import type { VisitorControl } from "./visitorControl";
import { buttonWords, doing, inLanguage, languageOf, subtitles } from "./visitorText";
import { type Words, wordsIn } from "./words";

interface Shown {
  control: VisitorControl;
  view: VisitorView;
  language: string;
  words: Words;
}

export function VisitorPage({ control }: { control: VisitorControl }) {
  const view = control.view.value;
  const phase = control.phase.value;
  const browser = typeof navigator === "undefined" ? [] : navigator.languages;
  const language = view?.tour
    ? languageOf(view, control.language.value, browser)
    : (control.language.value ?? browser[0] ?? "en");
  const words = wordsIn(language);
  const shown = view?.tour ? { control, view, language, words } : null;
  useEffect(() => {
    document.documentElement.lang = language;
  }, [language]);
  return (
    <div class="visitor" data-testid="visitor" data-phase={phase} data-state={shown ? view?.state : "none"}>
      {phase === "lost" && (
        <p class="note" role="status" data-testid="visitor-lost">
          {words.lost}
        </p>
      )}
      {shown ? (
        <Tour {...shown} />
      ) : (
        <main class="alone">
          <p role="status" data-testid="visitor-alone">
            {phase === "over" ? words.over : phase === "live" ? words.nothing : phase === "lost" ? "" : "…"}
          </p>
        </main>
      )}
    </div>
  );
}

function Tour(shown: Shown) {
  const { view, language, words } = shown;
  const title = inLanguage(view.title, language, view);
  const stop = inLanguage(view.stop_title, language, view);
  const does = doing(view, words);
  return (
    <>
      <header>
        <h1 lang={title.language}>{title.text}</h1>
        <Languages {...shown} />
      </header>
      <main>
        {stop.text && (
          <h2 data-testid="visitor-stop">
            {view.number > 0 && <span class="count">{words.stop(view.number, view.stops)}</span>}
            <span lang={stop.language}>{stop.text}</span>
          </h2>
        )}
        <Media {...shown} />
        {does && (
          <p class="does" role="status" data-testid="visitor-doing">
            {does}
          </p>
        )}
        <Said {...shown} />
      </main>
      <Presses {...shown} />
    </>
  );
}

function Languages({ control, view, language, words }: Shown) {
  if (view.languages.length < 2) return null;
  return (
    <select
      aria-label={words.language}
      data-testid="visitor-language"
      value={language}
      onChange={(event) => control.choose(event.currentTarget.value)}
    >
      {view.languages.map((tag) => (
        <option key={tag} value={tag} lang={tag}>
          {ownName(tag)}
        </option>
      ))}
    </select>
  );
}

function Media({ control, view, language }: Shown) {
  if (!view.shown) return null;
  const { file, alt, video } = view.shown;
  const { text } = inLanguage(alt, language, view);
  const address = control.mediaAddress(file);
  return video ? (
    <video
      key={file}
      class="media"
      data-testid="visitor-media"
      src={address}
      aria-label={text}
      controls
      muted
      autoplay
      playsInline
    />
  ) : (
    <img key={file} class="media" data-testid="visitor-media" src={address} alt={text} />
  );
}

/** The text of the step, of which one sentence is said now; and what the robot says beside it. */
function Said({ view, language }: Shown) {
  const text = subtitles(view, language);
  const now = useRef<HTMLSpanElement>(null);
  const at = text?.now ?? 0;
  useEffect(() => now.current?.scrollIntoView({ block: "nearest" }), [at, text?.sentences]);
  return (
    <>
      {text && (
        <p class="said" lang={text.language} data-testid="visitor-said" data-sentence={text.now}>
          {text.sentences.map((sentence, index) => (
            <span
              key={index}
              ref={index === text.now ? now : undefined}
              class={index === text.now ? "now" : index < text.now ? "before" : ""}
              aria-current={index === text.now}
            >
              {sentence}{" "}
            </span>
          ))}
        </p>
      )}
      {view.said && (
        <p class="beside" lang={view.language} aria-live="polite" data-testid="visitor-beside">
          {view.said}
        </p>
      )}
    </>
  );
}

function Presses({ control, view, language, words }: Shown) {
  const refusal = control.refusal.value;
  const off = control.busy.value || control.phase.value !== "live";
  if (view.buttons.length + view.questions.length === 0 && !refusal) return null;
  return (
    <footer>
      {refusal && (
        <p class="note" role="alert" data-testid="visitor-refusal">
          {words[refusal]}
        </p>
      )}
      {view.questions.length > 0 && (
        <div class="questions" role="group" aria-label={words.ask}>
          <h3>{words.ask}</h3>
          {view.questions.map(({ id, question }) => {
            const { text, language: used } = inLanguage(question, language, view);
            return (
              <button
                key={id}
                type="button"
                lang={used}
                data-testid="visitor-question"
                data-question={id}
                disabled={off}
                onClick={() => void control.press({ ask: id })}
              >
                {text}
              </button>
            );
          })}
        </div>
      )}
      {view.buttons.length > 0 && (
        <div class="buttons">
          {view.buttons.map((button) => (
            <button
              key={button}
              type="button"
              class={button === "decline" ? "quiet" : "main"}
              data-testid={`visitor-${button}`}
              disabled={off}
              onClick={() => void control.press({ button })}
            >
              {buttonWords(button, view, language, words)}
            </button>
          ))}
        </div>
      )}
    </footer>
  );
}

/** A language's name in itself, as its readers look for it. */
function ownName(tag: string): string {
  try {
    return new Intl.DisplayNames([tag], { type: "language" }).of(tag) ?? tag;
  } catch {
    return tag;
  }
}

/** What the robot says, over the view. */

import { useApp } from "../state/context";
import { subtitleOf } from "./subtitle";

export function Subtitles() {
  const { store } = useApp();
  const speech = store.of("speech").value;
  const subtitle = subtitleOf(speech, store.now.value);
  if (!subtitle) return null;
  return (
    <p class="subtitles" data-testid="subtitles" data-state={speech?.state} lang={speech?.language}>
      <span class="said">{subtitle.before}</span>
      {subtitle.word && <mark>{subtitle.word}</mark>}
      {subtitle.after}
    </p>
  );
}

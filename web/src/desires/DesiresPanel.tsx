/** The desires there are, those that ended last, and the form for one more. */

import { panel } from "../panels/panel";
import type { Message } from "../state/latest";
import { DesireForm } from "./DesireForm";
import { DesireList, EndedList } from "./DesireList";

export const desiresPanel = panel({ type: "desires", tab: "Attention", Card: Desires, offered: () => true });

function Desires({ message }: { message: Message<"desires"> | null }) {
  return (
    <section class="card" aria-label="Desires">
      <h2>
        Desires <span class="count">{message?.desires.length ?? 0}</span>
      </h2>
      <DesireList desires={message?.desires ?? null} accomplishments={message?.accomplishments ?? []} />
      <EndedList ended={message?.ended ?? []} />
      <DesireForm />
    </section>
  );
}

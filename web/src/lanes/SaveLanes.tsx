/** Saves what the lanes show as a file: SVG, PNG or CSV. */

import { useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { t } from "../i18n";
import { useApp } from "../state/context";
import { DownloadIcon } from "../ui/icons";
import type { LaneChart } from "./chart";

const PNG_SCALE = 2;

interface Props {
  chart: RefObject<LaneChart | null>;
  classes: readonly string[];
  suffix: string;
}

export function SaveLanes({ chart, classes, suffix }: Props) {
  const { store } = useApp();
  const open = useSignal(false);
  const save = async (kind: "svg" | "png" | "csv") => {
    open.value = false;
    const of = chart.current;
    if (!of) return;
    const { lanesCsv, lanesSvg } = await import("./saved");
    const svg = () => lanesSvg(of.shownHistory(), classes, of.edges(), store.hello.peek()?.scale.intensity ?? 8);
    const stamp = new Date(of.edges().to * 1000).toISOString().slice(0, 19).replaceAll(":", "-");
    const name = `lanes-${stamp}.${kind}`;
    if (kind === "csv")
      download(name, new Blob([lanesCsv(of.shownHistory(), classes, of.edges())], { type: "text/csv" }));
    else if (kind === "svg") download(name, new Blob([svg()], { type: "image/svg+xml" }));
    else download(name, await toPng(svg()));
  };
  return (
    <div class="lanes-save">
      <button
        type="button"
        class={`icon-button ${open.value ? "on" : ""}`}
        aria-label={t("Save what the lanes show")}
        title={t("Save as a picture or a table")}
        aria-expanded={open.value}
        data-testid={`lanes-save${suffix}`}
        onClick={() => (open.value = !open.value)}
      >
        <DownloadIcon />
      </button>
      {open.value && (
        <div class="lanes-save-kinds">
          {(["svg", "png", "csv"] as const).map((kind) => (
            <button key={kind} type="button" class="button small" onClick={() => void save(kind)}>
              {kind.toUpperCase()}
            </button>
          ))}
        </div>
      )}
    </div>
  );
}

async function toPng(svg: string): Promise<Blob> {
  const image = new Image();
  const address = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  try {
    image.src = address;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width * PNG_SCALE, image.height * PNG_SCALE);
    canvas.getContext("2d")!.drawImage(image, 0, 0, canvas.width, canvas.height);
    return await canvas.convertToBlob({ type: "image/png" });
  } finally {
    URL.revokeObjectURL(address);
  }
}

function download(name: string, blob: Blob): void {
  const address = URL.createObjectURL(blob);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  URL.revokeObjectURL(address);
}

/** A QR code, of its rows from the top (`1` for each black module), with its quiet zone. */

import { codePath, QUIET } from "./qrPath";

export function QrPicture({ code, label }: { code: readonly string[]; label: string }) {
  const side = code.length + 2 * QUIET;
  return (
    <svg class="qr-picture" viewBox={`0 0 ${side} ${side}`} role="img" aria-label={label} shape-rendering="crispEdges">
      <rect width={side} height={side} fill="#fff" />
      <path d={codePath(code)} fill="#000" />
    </svg>
  );
}

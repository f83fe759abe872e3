/** Writes each text file of the build a second and a third time, as Brotli and gzip pack it: served as they are. */

import { readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { extname, join, resolve } from "node:path";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";
import type { Plugin } from "vite";

const PACKED = new Set([".js", ".css", ".html", ".svg", ".md"]);
/** What is smaller gains nothing: an answer's header is as large. */
const LEAST_BYTES = 1000;

export function compress(): Plugin {
  let folder = "";
  return {
    name: "hbba-compress",
    apply: "build",
    configResolved(config) {
      folder = resolve(config.root, config.build.outDir);
    },
    closeBundle() {
      for (const name of readdirSync(folder, { recursive: true, encoding: "utf-8" })) {
        const file = join(folder, name);
        if (!PACKED.has(extname(name)) || statSync(file).size < LEAST_BYTES) continue;
        const plain = readFileSync(file);
        const text = { [constants.BROTLI_PARAM_MODE]: constants.BROTLI_MODE_TEXT };
        writeFileSync(`${file}.br`, brotliCompressSync(plain, { params: text }));
        writeFileSync(`${file}.gz`, gzipSync(plain, { level: 9 }));
      }
    },
  };
}

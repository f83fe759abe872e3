/// <reference types="vitest/config" />
import { defineConfig } from "vite";
import { scriptOf } from "./chunks";
import { compress } from "./compress";

// `npm run dev` serves the page with hot reload in front of a console that runs elsewhere.
const consoleAddress = process.env["HBBA_CONSOLE"] ?? "http://127.0.0.1:8080";

export default defineConfig({
  base: "./",
  plugins: [compress()],
  oxc: { jsx: { runtime: "automatic", importSource: "preact" } },
  build: {
    outDir: "../app/console/static",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: { polyfill: false },
    rolldownOptions: {
      input: ["index.html", "face.html", "visitor.html", "rest.html"],
      output: { codeSplitting: { includeDependenciesRecursively: false, groups: [{ name: scriptOf }] } },
    },
    license: { fileName: "licenses.md" },
    chunkSizeWarningLimit: 2000, // Swagger UI, on the page on REST alone
  },
  server: {
    proxy: {
      "/api": { target: consoleAddress, ws: true },
      "/viser": { target: consoleAddress, ws: true },
      // Not /src/panels, which is the page's own.
      "^/panels/": { target: consoleAddress },
    },
  },
  test: {
    include: ["src/**/*.test.ts"],
    environment: "node",
    // Files share a process and what they import: loading it again for each took most of the time.
    isolate: false,
    unstubGlobals: true,
    testTimeout: 60_000, // a busy computer is no fault of the page
  },
});

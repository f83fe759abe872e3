/// <reference types="vitest/config" />
import { defineConfig } from "vite";

// `npm run dev` serves the page with hot reload in front of a console (or dev/mock_server.py) that runs elsewhere.
const consoleAddress = process.env["HBBA_CONSOLE"] ?? "http://127.0.0.1:8080";

export default defineConfig({
  base: "./",
  oxc: { jsx: { runtime: "automatic", importSource: "preact" } },
  build: {
    outDir: "../app/console/static",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: { polyfill: false },
  },
  server: {
    proxy: {
      "/api": { target: consoleAddress, ws: true },
      "/viser": { target: consoleAddress, ws: true },
      // Not /src/panels, which is the page's own.
      "^/panels/": { target: consoleAddress },
    },
  },
  test: { include: ["src/**/*.test.ts"], environment: "node" },
});

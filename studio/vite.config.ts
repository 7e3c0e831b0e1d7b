// The bundle is committed and must be reproducible byte for byte: fixed names, no source maps, no
// hashes.
import { defineConfig, type Plugin } from "vite";
import { help } from "./help.ts";
import { leanThree } from "./three.lean.ts";

/**
 * Modules needed at the start of every page. Panels of other routes and the picture are loaded when
 * they are opened.
 */
const SHELL =
  /src.(?!main|worker|reader|files|site|gallery.|help.|run.|teach.|panels.(?!move|pose|tools|jogpad|connect)|view.(?!view|reach|layers|world|fence|tint)).*\.tsx?$/;

/** Inlines the style of the frame into the page, so that it is painted without a second request. */
const inlineStyle: Plugin = {
  name: "inline-style",
  enforce: "post",
  generateBundle(_, bundle) {
    const [page, style] = [bundle["index.html"], bundle["assets/app.css"]];
    if (page?.type !== "asset" || style?.type !== "asset") throw new Error("no page, or no style");
    const link = /<link rel="stylesheet"[^>]*app\.css">/;
    if (!link.test(String(page.source))) throw new Error("the page has no style");
    page.source = String(page.source).replace(link, () => `<style>${String(style.source).trim()}</style>`);
    delete bundle["assets/app.css"];
  },
};

export default defineConfig({
  base: "./",
  plugins: [leanThree, inlineStyle, help()],
  oxc: { jsx: { runtime: "automatic", importSource: "preact" } },
  build: {
    outDir: "../target/studio",
    emptyOutDir: true,
    target: "es2022",
    sourcemap: false,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    reportCompressedSize: false,
    rollupOptions: {
      output: {
        entryFileNames: "assets/app.js",
        codeSplitting: {
          groups: [
            { name: "preact", test: /node_modules.@?preact/ },
            { name: "three", test: /node_modules.three/ },
            { name: "shell", test: SHELL },
            { name: "body", test: /src.view.(body|solid|mesh|stand|camera)\.ts/ },
            {
              name: "jobs",
              test: /src.run.(?!bench|stored|paper|items|room|history|shapes|fills|laser)|src.panels.(job\.|armlaser|remedies|touch|paper|setup|programs|run\.css)/,
            },
            { name: "qr", test: /node_modules.lean-qr/ },
            {
              name: "sheet",
              test: /src.run.(bench|stored|paper|items|room|history|shapes|fills)|src.panels.(sheet|workshop|items|photo|presets|swatch|partslist)/,
            },
          ],
        },
        chunkFileNames: ({ facadeModuleId }) =>
          facadeModuleId?.includes("/said/") ? "assets/said-[name].js" : "assets/[name].js",
        // The initial style is `app`, and the style of a panel has the panel's name.
        assetFileNames: ({ names }) => (names.includes("index.css") ? "assets/app.css" : "assets/[name][extname]"),
      },
    },
  },
  worker: { format: "es", rollupOptions: { output: { entryFileNames: "assets/[name].js" } } },
});

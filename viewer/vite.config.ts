import { createHash } from "node:crypto";
import { readdirSync, readFileSync, statSync } from "node:fs";
import { join } from "node:path";
import { defineConfig, type Plugin } from "vite";
import { viteSingleFile } from "vite-plugin-singlefile";

/** A hash of all that the page is built from; python/radiosity/viewer/page.py computes the same. */
function fingerprint(): string {
  const inSource = (readdirSync("src", { recursive: true }) as string[])
    .map((name) => join("src", name).replaceAll("\\", "/"))
    .filter((name) => statSync(name).isFile());
  const names = [...inSource, "index.html", "package-lock.json", "tsconfig.json", "vite.config.ts"];
  const hash = createHash("sha256");
  for (const name of names.sort((a, b) => (a < b ? -1 : 1))) {
    const data = readFileSync(name);
    hash.update(`${name}\n${data.length}\n`).update(data);
  }
  return hash.digest("hex");
}

/** So that a page that is older than its sources is noticed. */
const mark: Plugin = {
  name: "mark",
  transformIndexHtml: () => [
    { tag: "meta", attrs: { name: "radiosity-sources", content: fingerprint() }, injectTo: "head" },
  ],
};

// One page without other files: what a server serves, and what is mailed with a scene in it.
export default defineConfig({
  plugins: [mark, viteSingleFile({ removeViteModuleLoader: true })],
  build: { target: "es2022", outDir: "../python/radiosity/viewer/bundle", emptyOutDir: true },
});

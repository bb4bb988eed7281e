// Unpacks the headless Chromium that npm ships and prints where it is, for tests on machines that have no browser:
// {"executable": "...", "libraries": "..."}. It has its own copy of the libraries that servers lack.

import { mkdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const place = join(dirname(fileURLToPath(import.meta.url)), "node_modules", ".chromium");
mkdirSync(place, { recursive: true });
process.env.TMPDIR = place; // where it unpacks to
process.env.AWS_LAMBDA_JS_RUNTIME = "nodejs22.x"; // so that it unpacks the libraries too
const { default: chromium } = await import("@sparticuz/chromium");
console.log(JSON.stringify({ executable: await chromium.executablePath(), libraries: join(place, "al2023", "lib") }));

// Bundle the page into ../static; the first line of each file is the SHA-256 of what it was made from.
import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { build } from "esbuild";

const here = import.meta.dirname;
const target = join(here, "..", "static");

/** The names and bytes of all sources, in the order of their names; tests/test_studio_page.py does the same. */
function sourceHash() {
  const files = readdirSync(join(here, "src"), { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => join(entry.parentPath, entry.name).slice(here.length + 1));
  const names = [...files, "build.mjs", "index.html", "package.json", "package-lock.json", "tsconfig.json"];
  const digest = createHash("sha256");
  for (const name of names.map((name) => name.replaceAll("\\", "/")).sort()) {
    const data = readFileSync(join(here, name));
    digest.update(`${name} ${data.length}\n`);
    digest.update(data);
  }
  return digest.digest("hex");
}

const first = `/* sources ${sourceHash()} */`;
await build({
  entryPoints: { studio: join(here, "src", "main.ts") },
  outdir: target,
  bundle: true,
  minify: true,
  format: "esm",
  target: ["chrome111", "firefox113", "safari16.4"],
  charset: "utf8",
  legalComments: "eof",
  banner: { js: first, css: first },
  logLevel: "info",
});
writeFileSync(join(target, "index.html"), readFileSync(join(here, "index.html")));

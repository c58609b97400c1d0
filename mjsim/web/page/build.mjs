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

/** The licences of the packages that went into the bundle, as their authors want them passed on. */
function licences(inputs) {
  const packages = Object.keys(inputs).flatMap(
    (input) => /.*node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(input)?.[1] ?? [],
  );
  const texts = [...new Set(packages)].sort().map((name) => {
    const folder = join(here, "node_modules", name);
    const file = readdirSync(folder).find((entry) => /^licen[cs]e/i.test(entry));
    const { version } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
    return `${name} ${version}\n\n${readFileSync(join(folder, file), "utf8").trim()}\n`;
  });
  return `studio.js, scene.js and studio.css contain these packages.\n\n${texts.join("\n----\n\n")}`;
}

const first = `/* sources ${sourceHash()} */`;
const { metafile } = await build({
  // The view in 3-D is fetched when it is first opened, tables of other languages when one is chosen.
  entryPoints: {
    studio: join(here, "src", "main.ts"),
    scene: join(here, "src", "scene", "scene.ts"),
    languages: join(here, "src", "words", "languages.ts"),
  },
  outdir: target,
  bundle: true,
  loader: { ".glsl": "text" },
  minify: true,
  format: "esm",
  target: ["chrome111", "firefox113", "safari16.4"],
  charset: "utf8",
  legalComments: "eof",
  banner: { js: first, css: first },
  logLevel: "info",
  metafile: true,
});
writeFileSync(join(target, "LICENSES.txt"), licences(metafile.inputs));
writeFileSync(join(target, "index.html"), readFileSync(join(here, "index.html")));

// Colours of texts are read on every surface, in light and in the dark, by the contrast of WCAG 2.
import assert from "node:assert/strict";
import { globSync, readFileSync } from "node:fs";
import { test } from "node:test";

const SOURCES = new URL("../../mjsim/web/page/src/", import.meta.url);
const STYLE = readFileSync(new URL("ui/theme.css", SOURCES), "utf8");
const [LIGHT, DARK] = STYLE.split(':root[data-theme="dark"]').map((half) => Object.fromEntries([...half.matchAll(/--([a-z-]+): (#[0-9a-f]{6});/g)].map(([, name, color]) => [name, color])));

const TEXTS = ["ink", "muted", "accent", "error", "warning"];
const SURFACES = ["page", "paper", "raised"];
/** Texts on a surface that is theirs. */
const PAIRS = [["ink", "hover"], ["muted", "hover"], ["ink", "accent-soft"], ["accent", "accent-soft"], ["error", "error-soft"], ["warning", "warning-soft"], ["on-accent", "accent"]];
const CODE = ["code-key", "code-text", "code-number", "code-note"].map((name) => [name, "paper"]);

function luminance(color) {
  const [red, green, blue] = [1, 3, 5].map((at) => {
    const part = Number.parseInt(color.slice(at, at + 2), 16) / 255;
    return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

function contrast(one, other) {
  const [low, high] = [luminance(one), luminance(other)].sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
}

for (const [scheme, colors] of Object.entries({ light: LIGHT, dark: DARK })) {
  test(`texts have a contrast of 4.5 to what is behind them, in ${scheme} colours`, () => {
    const pairs = [...TEXTS.flatMap((text) => SURFACES.map((surface) => [text, surface])), ...PAIRS, ...CODE];
    for (const [text, surface] of pairs) {
      const found = contrast(colors[text], colors[surface]);
      assert.ok(found >= 4.5, `${text} on ${surface}: ${found.toFixed(2)}`);
    }
  });

  test(`outlines of controls have a contrast of 3, in ${scheme} colours`, () => {
    for (const surface of ["page", "paper", "raised"]) assert.ok(contrast(colors.edge, colors[surface]) >= 3, surface);
  });
}

test("texts have these colours alone, but for names of axes in 3-D and shades of ink", () => {
  const known = new Set([...TEXTS, "on-accent"].map((name) => `var(--${name})`)).add("inherit");
  for (const file of globSync("**/*.css", { cwd: SOURCES })) {
    const style = readFileSync(new URL(file, SOURCES), "utf8").replace(/^\.scene-axes .*$/gm, "");
    for (const [, color] of style.matchAll(/[\s{;]color: ([^;]+);/g)) assert.ok(known.has(color) || color.endsWith("var(--ink))"), `${color} in ${file}`);
  }
});

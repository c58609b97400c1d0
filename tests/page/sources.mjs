// Lets Node read the page's TypeScript as it is, whose imports have no endings: `node --import ./sources.mjs FILE`.
import { registerHooks } from "node:module";

const SOURCES = new URL("../../mjsim/web/page/src/", import.meta.url);

registerHooks({
  resolve(name, context, next) {
    if (name.startsWith("page/")) return next(new URL(`${name.slice(5)}.ts`, SOURCES).href, context);
    const own = name.startsWith(".") && context.parentURL?.startsWith(SOURCES.href);
    return next(own ? `${name}.ts` : name, context);
  },
});

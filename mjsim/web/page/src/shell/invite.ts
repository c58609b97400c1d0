/** An address that lets in one more browser: this page makes it, because it is in already. */

import { postJson } from "../api";
import { ask, type Choice } from "../ui/dialog";
import { el } from "../ui/dom";
import { word } from "../words/words";
import type { Toasts } from "./toasts";

interface Invitation {
  url: string;
  /** For how long the address works; null when no token is asked for. */
  minutes: number | null;
}

export async function askInvite(toasts: Toasts): Promise<void> {
  let invitation: Invitation;
  try {
    invitation = await postJson<Invitation>("/api/invite", {});
  } catch (error) {
    toasts.error(error);
    return;
  }
  const { url, minutes } = invitation;
  const label = word("shell.address");
  const address = el("input", { class: "mono", value: url, readOnly: true, "aria-label": label, autofocus: true });
  address.addEventListener("focus", () => address.select());
  const hint = minutes === null ? word("shell.anyBrowserOfThis") : word("shell.itWorksOnceWithin", { minutes });
  const body = [el("p", {}, word("shell.openThisAddressIn")), address, el("p", { class: "hint" }, hint)];
  const close: Choice<boolean> = { text: word("shell.close"), value: false };
  // Browsers have no clipboard for pages of other machines without encryption.
  const choices = window.isSecureContext
    ? [close, { text: word("shell.copy"), value: true, kind: "primary" as const }]
    : [close];
  const copy = await ask(word("shell.openInAnotherBrowser"), body, choices);
  if (copy) await navigator.clipboard.writeText(url).catch((error: unknown) => toasts.error(error));
}

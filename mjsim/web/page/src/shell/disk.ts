/** What happens when the file of the world that is open, or a file that it names, changes on disk. */

import type { Opened } from "../api";
import { newestWins } from "../ui/signal";
import { word } from "../words/words";
import type { Files } from "./files";
import type { Notices } from "./notices";
import type { TabLink } from "./tab";
import type { Studio } from "./view";

/** While a drag goes on, or a save, it is looked at again after this long [ms]. */
const LATER = 300;

export class Disk {
  /** What the file has, as far as the server has told; null: it is gone. */
  private newest: { path: string; stamp: string | null } | null = null;
  /** The state of the file that the person was told of. */
  private told = "";
  private readonly look = newestWins<void>(() => this.lookNow());

  constructor(
    private readonly studio: Studio,
    private readonly link: TabLink,
    private readonly files: Files,
    private readonly notices: Notices,
  ) {
    const { document: world } = studio;
    link.disk.on((news) => {
      this.newest = news;
      this.look();
    });
    link.files.on((names) => void this.readAgain(names));
    world.parsedChanged.on(() => this.show());
    world.stateChanged.on(() => {
      this.show();
      this.look();
    });
  }

  /** Tell the server what is to be watched. */
  private show(): void {
    const { path, stamp, needsName, parsed } = this.studio.document;
    this.link.show({ path: path ?? "", stamp: needsName ? null : stamp, files: parsed.files });
  }

  private async lookNow(): Promise<void> {
    const { document: world } = this.studio;
    if (this.newest?.path !== world.path || this.newest.stamp === world.stamp) return this.same();
    if (this.files.isSaving || world.isBusy) {
      window.setTimeout(() => this.look(), LATER);
      return;
    }
    if (this.newest.stamp !== null && !world.isEdited) return this.reload(this.newest.path);
    const state = `${this.newest.path} ${this.newest.stamp}`;
    if (state === this.told) return;
    this.told = state;
    if (this.newest.stamp === null) this.noteGone(this.newest.path);
    else await this.ask(this.newest.path);
  }

  /** The file is as this page knows it. */
  private same(): void {
    this.told = "";
    this.studio.document.noteGone(false);
    for (const key of ["disk", "gone"]) this.notices.clear(key);
  }

  private noteGone(path: string): void {
    this.notices.clear("disk");
    const text = word("shell.isNoLongerOn", { path });
    this.notices.set("gone", text, [
      { text: word("shell.saveItAgain"), kind: "primary", act: () => void this.files.save() },
    ]);
    this.studio.document.noteGone(true);
  }

  private async reload(path: string): Promise<void> {
    const { document: world, toasts } = this.studio;
    const before = world.text;
    const opened = await this.open(path);
    if (!opened) return;
    if (opened.stamp === world.stamp) return this.same(); // the news was of a save before the last one
    // The person may have begun to change something meanwhile.
    if (world.isEdited || world.isBusy) return this.look();
    world.reload(opened);
    if (world.text !== before) toasts.done(word("shell.reloadedFromDisk", { path }));
  }

  private async ask(path: string): Promise<void> {
    const { document: world } = this.studio;
    const opened = await this.open(path);
    if (!opened) return;
    if (opened.stamp === world.stamp) return this.same();
    this.told = `${path} ${opened.stamp}`;
    if (opened.text === world.text) return world.rebase(opened);
    this.notices.clear("gone");
    this.notices.set("disk", word("shell.changedOnDiskAndHere", { path }), [
      { text: word("shell.loadTheOneOn"), title: word("shell.undoLeadsBackTo"), act: () => void this.files.reload() },
      { text: word("shell.keepBoth"), title: word("shell.saveYoursBesideIt"), act: () => void this.files.keepBoth() },
      { text: word("shell.keepMine"), title: word("shell.goOnSavingOverwrites"), act: () => void this.keepMine(path) },
    ]);
  }

  private async keepMine(path: string): Promise<void> {
    const opened = await this.open(path);
    if (opened) this.studio.document.rebase(opened);
  }

  /** Read the file, if it is still that of the world that is open; its state is the newest then. */
  private async open(path: string): Promise<Opened | null> {
    const { api, document: world, toasts } = this.studio;
    try {
      const opened = await api.open(path);
      if (world.path !== path) return null;
      this.newest = { path, stamp: opened.stamp };
      return opened;
    } catch (error) {
      toasts.error(error);
      // It is looked at again when it has changed again.
      if (this.newest) this.newest = { path, stamp: world.stamp };
      return null;
    }
  }

  /** Files that the world names have changed: it is read again, and pictures are fetched anew. */
  private async readAgain(names: string[]): Promise<void> {
    const { api, document: world, toasts } = this.studio;
    if (!world.isOpen) return;
    api.version++;
    await world.read();
    await this.studio.refresh().catch((error) => toasts.error(error));
    const [first, ...others] = names;
    const count = names.length;
    toasts.done(others.length ? word("shell.filesOfThisWorld", { count }) : word("shell.changedOnDisk", { first }));
  }
}

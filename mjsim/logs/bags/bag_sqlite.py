"""SQLite files of bags, with any characters in their paths, and with changes that a killed recorder had not merged."""

import shutil
import sqlite3
from contextlib import ExitStack, closing
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import quote

from rosbags.rosbag2 import ReaderError
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

LOG = "-wal"
"""Suffix of the file with the changes that SQLite has not merged yet (write-ahead log)."""


class SqliteFile(Sqlite3Reader):
    """A file of a bag in SQLite."""

    def open(self) -> None:
        """Open it, or a merged copy if a recorder that was killed left a write-ahead log."""
        given = Path(str(self.path))
        with ExitStack() as undo:
            log = given.with_name(given.name + LOG)
            path = _merged(given, log, undo) if log.is_file() and log.stat().st_size else given
            # The parent class puts it in a URI, where ? and # have a meaning.
            self.path = Path(quote(str(path)))
            try:
                super().open()
            except ReaderError as error:
                raise ReaderError(f"{error}".replace(str(self.path), str(given))) from None
            finally:
                self.path = given
            self._undo = undo.pop_all()

    def close(self) -> None:
        """Close it."""
        super().close()
        self._undo.close()


def _merged(path: Path, log: Path, undo: ExitStack) -> Path:
    """Return a temporary copy of a database with its log merged; the log's own folder is left as it is."""
    folder = Path(undo.enter_context(TemporaryDirectory()))
    copy = folder / "bag.db3"
    shutil.copyfile(path, copy)
    shutil.copyfile(log, folder / f"{copy.name}{LOG}")
    with closing(sqlite3.connect(copy)) as database:
        database.execute("PRAGMA journal_mode=DELETE")
    return copy

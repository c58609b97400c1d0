"""Tables of recordings for pandas, if it is installed."""

from typing import TYPE_CHECKING

from mjsim.errors import UsageError, did_you_mean, how_to_install
from mjsim.notebook.plots import chosen
from mjsim.record import Recording, recording_tables

if TYPE_CHECKING:
    from pandas import DataFrame


def frame_of(recording: Recording, table: str | None) -> "DataFrame":
    """Return a table of a recording; `Recording.frame` describes the names.

    Raises:
        UsageError: There is no such table, or pandas is not installed.
    """
    try:
        from pandas import DataFrame
    except ImportError:
        raise UsageError(f"frame() needs pandas, which is not installed; type: {how_to_install('pandas')}") from None
    wanted = chosen(recording, None) if table is None else table
    wanted = f"{wanted}_track" if wanted in recording.robots else wanted
    known = []
    for name, header, rows in recording_tables(recording):
        if name == wanted:
            frame = DataFrame([list(row) for row in rows], columns=list(header))
            # A column without values counts as numeric.
            return frame.astype(dict.fromkeys(frame.columns[frame.isna().all()], float))
        known.append(name)
    raise UsageError(f"no table '{wanted:.40}' in '{recording.path}'{did_you_mean(wanted, known)}")

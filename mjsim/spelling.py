"""Spells names of things in ASCII, for formats limited to it: ROS, fields of Octave and MATLAB."""


def ascii_name(name: str) -> str:
    """Return a name in letters, digits and `_` of ASCII, with no digit first.

    Letters beyond ASCII become `uXXXX_`, from which they can be read back; other characters become `_`. A leading
    digit gets the prefix `x`. Names that become equal are refused, or numbered, by the format that writes them.
    """
    plain = "".join(map(_spelled, name))
    return f"x{plain}" if plain[:1].isdigit() else plain


def spellings(names: dict[str, str]) -> str:
    """Return, in a line, the names whose letters beyond ASCII are spelled differently; '' if there are none."""
    return ", ".join(f"'{name}' is '{plain}'" for name, plain in names.items() if not name.isascii())


def _spelled(character: str) -> str:
    if character.isascii():
        return character if character.isalnum() else "_"
    return f"u{ord(character):04X}_"

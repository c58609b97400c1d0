"""Sentences for people: English text that keeps the template and the values it was made from, for other languages."""

import string
from collections.abc import Iterator, Mapping
from typing import Any, Self

_FORMATTER = string.Formatter()
_AFTER_NOUN = (" of ", " called ", " without ", " beside ", " outside ", " drawn ", " in ", " on ", " that ", " far ")
"""Words after the noun of a group of words; only the noun has a plural."""


class Sentence(str):
    """A sentence with values: `Sentence("no robot '{robot}'{meant}", name, meant)`.

    It is the English text as a string. The template is the code of the sentence, like the msgid of gettext: it is the
    key in the tables of other languages. Values may be sentences too. A sentence without values is a plain string,
    which is its own code.
    """

    __slots__ = ("template", "values")
    template: str
    """The braces hold only names of values."""
    values: Mapping[str, str]
    """Values as text, formatted as in the sentence."""

    def __new__(cls, template: str, /, *given: Any) -> Self:
        """Fill a template: its braces hold names, and formats as in `str.format`; values go by first occurrence."""
        fields = [(name, form, as_) for _, name, form, as_ in _FORMATTER.parse(template) if name is not None]
        by_name = dict(zip(dict.fromkeys(name for name, _, _ in fields), given, strict=True))
        values = {name: _text(by_name[name], form, as_) for name, form, as_ in fields}
        self = super().__new__(cls, plain(template).format_map(values))
        self.template, self.values = plain(template), values
        return self

    @classmethod
    def received(cls, template: str, values: Mapping[str, str]) -> Self:
        """Return the sentence of a plain template and its values, which come from another process.

        Raises:
            ValueError: Braces of the template hold something other than names of the values.
        """
        fields = [(name, form, as_) for _, name, form, as_ in _FORMATTER.parse(template) if name is not None]
        if any(form or as_ or not name.isidentifier() or name not in values for name, form, as_ in fields):
            raise ValueError(f"{template!r:.80} is no template of {', '.join(values)!r:.80}")
        return cls(template, *(values[name] for name in dict.fromkeys(name for name, _, _ in fields)))

    def __str__(self) -> str:
        """Return the sentence itself, so that the text of an error made from one is still a sentence."""
        return self

    def __getnewargs__(self) -> tuple[Any, ...]:
        """Copy and pickle by template and values."""
        return (self.template, *self.values.values())


def plain(template: str) -> str:
    """Return a template without formats of values."""
    parts = [(text.replace("{", "{{").replace("}", "}}"), name) for text, name, _, _ in _FORMATTER.parse(template)]
    return "".join(text if name is None else f"{text}{{{name}}}" for text, name in parts)


def _text(value: Any, form: str | None, as_: Any) -> str:
    """Return a value as text; a sentence, or an error that holds one, stays a sentence."""
    return format(_FORMATTER.convert_field(value, as_), form or "") if form or as_ else str(value)


def with_sentences(answer: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a JSON answer, extended by template and values of each sentence in it, keyed by English text."""
    found = {each: [each.template, each.values] for each in sentences_in(answer)}
    return {**answer, "sentences": found} if found else answer


def sentences_in(value: Any) -> Iterator[Sentence]:
    """Yield the sentences in a JSON value, at any depth, and those in their values."""
    if isinstance(value, Sentence):
        yield value
        yield from sentences_in(value.values)
    elif isinstance(value, Mapping):
        for item in value.values():
            yield from sentences_in(item)
    elif isinstance(value, (list, tuple)) and not (value and isinstance(value[0], (int, float))):  # not rows of numbers
        for item in value:
            yield from sentences_in(item)


def number_of(count: int, noun: str) -> str:
    """Return a number with its noun: '1 wall', '2 walls', '3 parts of a mesh'.

    Args:
        count: The number.
        noun: A regular English noun, alone or with words after it, as in 'part of a mesh'.
    """
    return f"{count} {noun if count == 1 else _plural(noun)}"


def _plural(group: str) -> str:
    """Return the plural of a noun with words after it."""
    end = min((at for word in _AFTER_NOUN if (at := group.find(word)) >= 0), default=len(group))
    noun, rest = group[:end], group[end:]
    if noun == "person":
        return f"people{rest}"
    if noun.endswith("y") and noun[-2:-1] not in "aeiou":
        return f"{noun[:-1]}ies{rest}"
    return f"{noun}{'es' if noun.endswith(('s', 'x', 'z', 'ch', 'sh')) else 's'}{rest}"

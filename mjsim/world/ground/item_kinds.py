"""Items of several kinds, such as drives and sensors: the kind decides how an item is validated."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, cast

from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from mjsim.sentences import Sentence


def kind_of(item: object, kinds: Mapping[str, type[BaseModel]]) -> str | None:
    """Return the kind of an item, from its model or from the key that names the kind; None if it has none."""
    if isinstance(item, Mapping):
        return next((kind for kind in kinds if kind in item), None)
    return next((kind for kind, model in kinds.items() if isinstance(item, model)), None)


@dataclass(frozen=True, slots=True, eq=False)
class OneOf:
    """Annotates a union of models in `Annotated`; errors then refer only to the kind in question.

    In the path of an error, the kind is a separate step in angle brackets.
    """

    kinds: Mapping[str, type[BaseModel]]
    """The models by kind."""
    wrong: str
    """Message for an item without a kind."""
    kind_of: Callable[[Any, Mapping[str, type[BaseModel]]], str | None] = kind_of
    """Returns the kind of an item from its keys, or from its model if already built."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the validation schema of an item."""
        choices = {f"<{kind}>": _lazy_schema(model) for kind, model in self.kinds.items()}
        return core_schema.tagged_union_schema(
            choices,
            self._tag,
            custom_error_type="kind",
            custom_error_message=self.wrong,
            serialization=core_schema.simple_ser_schema("any"),
        )

    def __get_pydantic_json_schema__(self, _: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return the JSON Schema: one of the models' schemas."""
        for model in self.kinds.values():
            model.model_rebuild()
        models = (core_schema.definitions_schema(model.__pydantic_core_schema__, []) for model in self.kinds.values())
        return {"oneOf": [handler(model) for model in models]}

    def _tag(self, item: object) -> str | None:
        kind = self.kind_of(item, self.kinds)
        return None if kind is None else f"<{kind}>"


_SHAPES: Mapping[str, tuple[str, tuple[type, ...]]] = {
    "truth": ("true or false", (bool,)),
    "number": ("a number", (int, float)),
    "word": ("a word", (str,)),
    "list": ("a list", (list, tuple)),
    "keys": ("keys with values", (Mapping, BaseModel)),
}
"""Name and types of a value of each shape."""


@dataclass(frozen=True, slots=True)
class Shaped:
    """Annotates a union whose choices differ in shape, named in their order; errors then refer only to one choice."""

    shapes: tuple[str, ...]
    """Shapes of truth, number, word, list, keys."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the validation schema: the shape of a value chooses."""
        union: Any = handler(source)
        named = {_said(shape, choice): choice for shape, choice in zip(self.shapes, union["choices"], strict=True)}
        choices = [_naming_others(choice, [each for each in named if each != name]) for name, choice in named.items()]
        return core_schema.tagged_union_schema(
            {f"<{shape}>": choice for shape, choice in zip(self.shapes, choices, strict=True)},
            self._tag,
            custom_error_type="shape",
            custom_error_message=Sentence("it must be {right}", _either(named)),
        )

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return the JSON Schema of the union."""
        return {"anyOf": handler(schema)["oneOf"]}

    def _tag(self, value: object) -> str | None:
        return next((f"<{shape}>" for shape in self.shapes if isinstance(value, _SHAPES[shape][1])), None)


def _said(shape: str, choice: Any) -> str:
    """Return the name of a value of a shape; for a list of fixed length, with its length."""
    count = choice.get("max_length")
    fixed = shape == "list" and count is not None and count == choice.get("min_length")
    return Sentence("a list of {count} numbers", count) if fixed else _SHAPES[shape][0]


def _naming_others(choice: Any, others: list[str]) -> CoreSchema:
    """Return the schema of a choice; the error for a word that is not allowed names the other choices too."""
    if choice["type"] != "literal":
        return cast(CoreSchema, choice)
    words = _either([*map(repr, choice["expected"]), *others])
    return core_schema.custom_error_schema(choice, "literal_error", custom_error_context={"expected": words})


def _either(parts: Iterable[str]) -> str:
    *others, last = parts
    return Sentence("{others} or {last}", ", ".join(others), last)


def _lazy_schema(model: type[BaseModel]) -> CoreSchema:
    """Return a validation schema that builds the model's validator on first use: a world uses few kinds."""

    def check(item: Any, info: ValidationInfo) -> BaseModel:
        made: BaseModel = model.__pydantic_validator__.validate_python(item, context=info.context)
        return made

    return core_schema.with_info_plain_validator_function(check)

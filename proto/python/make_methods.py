#!/usr/bin/python3
"""Generates ovws_client/methods.py from the JSON Schemas: every method of the daemon with its types and documentation.

    make_methods.py SCHEMAS METHODS_PY      SCHEMAS: the folder written by write_schemas
"""
import json
import re
import sys
import textwrap
from pathlib import Path

WIDTH = 140
PLAIN = {"number": "float", "integer": "int", "boolean": "bool", "string": "str", "null": "None"}
HEAD = '''"""Every method of the daemon, with its types and its words. Made by make_methods.py from the daemon's field tables: change them.

What is LEFT_OUT stays as it is, or is the default. Results are dicts, as the wire has them.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Any, Final, Literal, NotRequired, TypedDict


class LeftOut(Enum):
    """The type of LEFT_OUT: None would be a value, the wire's null."""

    LEFT_OUT = "left out"

    def __repr__(self) -> str:
        return "LEFT_OUT"


LEFT_OUT: Final = LeftOut.LEFT_OUT


def _given(**params: object) -> dict[str, object]:
    return {name: value for name, value in params.items() if value is not LEFT_OUT}
'''


def wrapped(text, first, later=None):
    """Wraps text into lines. The first begins with `first`, further ones with `later` (default: spaces of the same width)."""
    return textwrap.wrap(text, WIDTH, initial_indent=first, subsequent_indent=" " * len(first) if later is None else later,
                         break_long_words=False, break_on_hyphens=False)


def without_bounds(schema):
    if isinstance(schema, dict):
        return {key: without_bounds(value) for key, value in schema.items() if key not in ("minimum", "maximum")}
    return schema


class Structures:
    """The objects with named keys in all schemas, each once: one TypedDict for each field table of the daemon."""

    def __init__(self):
        self._schemas = {}  # by name

    def collect(self, whole):
        """Adds the objects of one complete schema: itself, if it has a title, and its definitions."""
        roots = {whole["title"]: whole} if "title" in whole else {}
        for name, schema in (roots | whole.get("$defs", {})).items():
            self._add(name, schema)
        self._collect_unnamed(whole)

    def _add(self, name, schema):
        kept = {key: value for key, value in schema.items() if key not in ("$defs", "$schema", "examples", "title")}
        if without_bounds(self._schemas.setdefault(name, kept)) != without_bounds(kept):
            raise ValueError(f"two structures are called {name}")

    def _collect_unnamed(self, schema):
        """Adds nested objects that have a title."""
        for value in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
            if isinstance(value, dict) and "title" in value and "properties" in value:
                self._add(value["title"], value)
            self._collect_unnamed(value)

    def lines(self):
        for name, schema in sorted(self._schemas.items()):
            if not schema["properties"]:
                continue
            yield from ["", "", f"class {name}(TypedDict):"]
            for key, value in schema["properties"].items():
                yield from wrapped(described(value), "    # ", "    # ")
                kind = self.type_of(value, "list")
                yield f"    {key}: " + (kind if key in schema.get("required", []) else f"NotRequired[{kind}]")

    def type_of(self, schema, array):
        if "$ref" in schema:
            return schema["$ref"].split("/")[-1]
        if "const" in schema or "enum" in schema:
            return f"Literal[{', '.join('None' if v is None else json.dumps(v) for v in schema.get('enum', [schema.get('const')]))}]"
        for either in ("oneOf", "anyOf"):
            if either in schema:
                return " | ".join(self.type_of(part, array) for part in schema[either])
        if "title" in schema:
            return schema["title"]
        kinds = schema.get("type", [])
        kinds = [kinds] if isinstance(kinds, str) else kinds
        return " | ".join(PLAIN.get(kind) or self.composed(kind, schema, array) for kind in kinds) or "Any"

    def composed(self, kind, schema, array):
        if kind == "array":
            return f"{array}[{self.type_of(schema['items'], array)}]"
        values = schema.get("additionalProperties")
        return f"dict[str, {self.type_of(values, array)}]" if isinstance(values, dict) else "dict[str, Any]"


def sentence(text):
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "…")) else ".")


def described(schema):
    """The description with limits and default."""
    parts = [schema.get("description", "")]
    low, high = schema.get("minimum"), schema.get("maximum")
    if low is not None and high is not None:
        parts.append(f"from {low:.10g} to {high:.10g}")
    if "default" in schema:
        parts.append(f"default {json.dumps(schema['default'])}")
    return "; ".join(filter(None, parts))


def given_keys(schema):
    """The keys of the params, required ones first."""
    return sorted(schema["params"]["properties"], key=lambda key: key not in schema["params"].get("required", []))


def signature_lines(structures, name, schema, prefix):
    required = schema["params"].get("required", [])
    kinds = {key: structures.type_of(schema["params"]["properties"][key], "Sequence") for key in given_keys(schema)}
    arguments = ["self"] + [f"{key}: {kinds[key]}" for key in kinds if key in required]
    arguments += ["*"] * (len(kinds) > len(required))
    arguments += [f"{key}: {kinds[key]} | LeftOut = LEFT_OUT" for key in kinds if key not in required]
    begin, end = f"    {prefix}def {name.replace('.', '_')}(", f") -> {structures.type_of(schema['result'], 'list')}:"
    line = begin + ", ".join(arguments) + end
    yield ""
    yield from [line] if len(line) <= WIDTH else [begin, *(f"        {argument}," for argument in arguments), "    " + end]


def docstring(name, schema, whole):
    yield from wrapped(f'"""`{name}`. {sentence(schema["description"])}', "        ")
    yield ""
    if whole:
        for key in given_keys(schema):
            yield from wrapped(described(schema["params"]["properties"][key]), f"        {key}: ")
        results = schema["result"].get("properties", {}).items()
        yield from wrapped("; ".join(f"{key}: {value['description']}" for key, value in results), "        Result: ")
    else:
        yield f"        Params and result: `Methods.{name.replace('.', '_')}`."
    yield '        """'


def body_lines(structures, name, schema, wait):
    begin = f"        result: {structures.type_of(schema['result'], 'list')} = {wait}self.call(\"{name}\""
    given = ", ".join(f"{key}={key}" for key in given_keys(schema))
    line = begin + (f", _given({given}))" if given else ")")
    yield from [line] if len(line) <= WIDTH else [begin + ", _given(", *wrapped(given, "            "), "        ))"]
    yield "        return result"


def module(folder):
    schemas = {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob("*.json")) if not path.name.startswith("stream.")}
    structures = Structures()
    for schema in schemas.values():
        structures.collect({key: value for key, value in schema["params"].items() if key != "title"})
        structures.collect(schema["result"])
    lines = HEAD.splitlines() + list(structures.lines())
    for title, prefix, wait in (("Methods", "", ""), ("AsyncMethods", "async ", "await ")):
        lines += ["", "", f"class {title}:",
                  '    """What a client inherits: one Python method for each of the daemon\'s, carried out by `call`."""', "",
                  f"    {prefix}def call(self, method: str, params: Mapping[str, object] | None = None) -> Any:",
                  "        raise NotImplementedError"]
        for name, schema in schemas.items():
            lines += signature_lines(structures, name, schema, prefix)
            lines += docstring(name, schema, whole=not prefix)
            lines += body_lines(structures, name, schema, wait)
    return "\n".join(lines) + "\n"


def main():
    schemas, made = map(Path, sys.argv[1:])
    made.write_text(module(schemas))


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Makes ovws_client/methods.py from proto/schema: every method of the daemon with its types and its words.

    proto/python/make_methods.py            writes the file anew
    proto/python/make_methods.py --print    prints it instead
"""
import json
import re
import sys
import textwrap
from collections import defaultdict
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCHEMAS = HERE.parent / "schema"
MADE = HERE / "ovws_client" / "methods.py"
WIDTH = 140
PLAIN = {"number": "float", "integer": "int", "boolean": "bool", "string": "str", "null": "None"}
# Structures that the wire gives no name, by their keys.
NAMES = {
    ("j", "waves"): "ModeByJ", ("m", "n", "waves"): "ModeByOrders", ("j", "m", "n", "name", "waves"): "Mode",
    ("height", "width", "x", "y"): "Roi", ("increment", "max", "min"): "Range", ("job",): "JobStarted",
}
HEAD = '''"""Every method of the daemon, with its types and its words. Made by make_methods.py from proto/schema: change it there.

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


def camel(text):
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[._]", text))


def wrapped(text, first, later=None):
    """Lines that begin with `first`, and with `later` from the second on (as far in, if nothing is said)."""
    return textwrap.wrap(text, WIDTH, initial_indent=first, subsequent_indent=" " * len(first) if later is None else later,
                         break_long_words=False, break_on_hyphens=False)


class Structures:
    """The objects with named keys in all schemas, each told once: one TypedDict per distinct set of keys, types and descriptions."""

    def __init__(self):
        self._paths = defaultdict(list)  # structure -> where it stands
        self._schemas = {}
        self._names = {}

    @staticmethod
    def identity(schema):
        """What makes two objects the same: all but limits, examples and the object's own description."""
        def kept(value, top=False):
            if isinstance(value, dict):
                return {k: kept(v) for k, v in value.items() if k not in ("minimum", "maximum", "examples", "default", "$schema", "title")
                        and not (top and k in ("description", "type"))}
            return value
        return json.dumps(kept(schema, True), sort_keys=True)

    def collect(self, schema, path):
        for part in schema.get("oneOf", []):
            self.collect(part, path)
        if "items" in schema:
            self.collect(schema["items"], (*path[:-1], re.sub(r"s$", "", path[-1])))
        if isinstance(schema.get("additionalProperties"), dict):
            self.collect(schema["additionalProperties"], path)
        for name, value in schema.get("properties", {}).items():
            self.collect(value, (*path, name))
        if schema.get("properties"):
            key = self.identity(schema)
            self._paths[key].append(path)
            self._schemas[key] = schema

    def name_all(self):
        """A short name where nothing else wants it: the keys' own, else the key it stands under, else with what it belongs to."""
        taken = {"LeftOut", "Methods", "AsyncMethods"}
        for key, paths in self._paths.items():
            name = next(n for n in self.wishes(key, paths) if n not in taken)
            taken.add(name)
            self._names[key] = name

    def wishes(self, key, paths):
        by_keys = NAMES.get(tuple(sorted(self._schemas[key]["properties"])))
        if by_keys:
            yield by_keys
        ends = {path[-1] for path in paths}
        if len(paths[0]) == 1:
            yield camel(paths[0][0].split(".")[0] if len(paths) > 1 else paths[0][0]) + "Result"
        elif len(ends) == 1:
            yield camel(paths[0][-1])
        yield camel(paths[0][0].replace("system.", "").split(".")[0]) + camel(paths[0][-1])
        yield "".join(map(camel, paths[0]))

    def name(self, schema):
        return self._names[self.identity(schema)]

    def lines(self):
        for key, schema in self._schemas.items():
            yield from ["", "", f"class {self._names[key]}(TypedDict):"]
            if schema.get("description"):
                yield from wrapped(f'"""{sentence(schema["description"])}"""', "    ")
                yield ""
            for name, value in schema["properties"].items():
                yield from wrapped(described(value), "    # ", "    # ")
                kind = self.type_of(value, "list")
                yield f"    {name}: " + (kind if name in schema.get("required", []) else f"NotRequired[{kind}]")

    def type_of(self, schema, array):
        if "const" in schema or "enum" in schema:
            return f"Literal[{', '.join('None' if v is None else json.dumps(v) for v in schema.get('enum', [schema.get('const')]))}]"
        if "oneOf" in schema:
            return " | ".join(self.type_of(part, array) for part in schema["oneOf"])
        kinds = schema.get("type", [])
        kinds = [kinds] if isinstance(kinds, str) else kinds
        return " | ".join(PLAIN.get(kind) or self.composed(kind, schema, array) for kind in kinds) or "Any"

    def composed(self, kind, schema, array):
        if kind == "array":
            return f"{array}[{self.type_of(schema['items'], array)}]" if "items" in schema else f"{array}[Any]"
        if schema.get("properties"):
            return self.name(schema)
        values = schema.get("additionalProperties")
        return f"dict[str, {self.type_of(values, array)}]" if isinstance(values, dict) else "dict[str, Any]"


def sentence(text):
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "…")) else ".")


def described(schema):
    """The description with its limits and default."""
    parts = [schema.get("description", "")]
    low, high = schema.get("minimum"), schema.get("maximum")
    if low is not None and high is not None:
        parts.append(f"from {low:.10g} to {high:.10g}")
    if "default" in schema:
        parts.append(f"default {json.dumps(schema['default'])}")
    return "; ".join(filter(None, parts))


def given_keys(schema):
    """The params, those that must be given first."""
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


def module():
    schemas = {path.stem: json.loads(path.read_text()) for path in sorted(SCHEMAS.glob("*.json")) if not path.name.startswith("stream.")}
    structures = Structures()
    for name, schema in schemas.items():
        for key, value in schema["params"]["properties"].items():
            structures.collect(value, (name, key))
        structures.collect(schema["result"], (name,))
    structures.name_all()
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
    if sys.argv[1:] == ["--print"]:
        sys.stdout.write(module())
    else:
        MADE.write_text(module())


if __name__ == "__main__":
    main()

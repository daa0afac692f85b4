"""Validates the encoders, the decoders and WIRE.md's examples against the JSON Schemas.

Usage: validate_messages.py EMITTER SOURCE_DIR SCHEMAS
"""
import collections
import copy
import json
import pathlib
import re
import subprocess
import sys
import unittest

from jsonschema import Draft202012Validator as Validator

EMITTER, SOURCE, MADE = sys.argv[1], *map(pathlib.Path, sys.argv[2:])


def refuse_constant(text):
    raise ValueError(f"{text} is not strict JSON")


def strict(text):
    return json.loads(text, parse_constant=refuse_constant)


def read_all(folder):
    return {path.stem: strict(path.read_text()) for path in sorted(folder.glob("*.json"))}


SCHEMAS = read_all(MADE)
LINES = [strict(line) for line in subprocess.run(
    [EMITTER], check=True, capture_output=True, text=True).stdout.splitlines()]


def schema_of(line):
    schema = SCHEMAS[line["schema"]]
    return schema[line["part"]] if "part" in line else schema


def all_schemas():
    for name, schema in SCHEMAS.items():
        if name.startswith("stream."):
            yield name, schema
        else:
            yield name + " params", schema["params"]
            yield name + " result", schema["result"]


def objects_within(schema):
    """All parts of a schema that describe an object with named keys."""
    if isinstance(schema, dict):
        if "properties" in schema and "type" in schema:
            yield schema
        for key, value in schema.items():
            if key not in ("examples", "const", "enum"):
                yield from objects_within(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from objects_within(value)


UNIT_IN_NAME = re.compile(r"(^|[._])(px|nm|um|mm|us|ms|s|ns|hz|db|dn|e|deg|waves?|rad|rad2|cpp|mib|per_(px|cycle|wave|dn|pixel)|bytes|raw)($|[._])")
UNIT_IN_WORDS = re.compile(r"\b(pixels?|pupil radii|waves?|seconds?|hours?|microseconds|milliseconds|Hz|DN|electrons?|dB|degrees?|radians?|lambda/d|cycles?|grooves"
                           r"|part|fraction|ratio|times|factor|units of|to 1|-1 to|over the|number|quality|when it was taken|in use|magnif\w+|camera to|to the camera)\b")


def numbers_within(schema, key=""):
    """(key path, description) of all fields with fractional numbers, also in arrays; integers are counts, indices or have their unit in the name."""
    types = schema.get("type", [])
    if "number" in types:
        yield key, schema.get("description", "")
    for name, value in schema.get("properties", {}).items():
        yield from numbers_within(value, f"{key}.{name}")
    if "items" in schema:
        yield from numbers_within({"description": schema.get("description", "")} | schema["items"], key)


class Schemas(unittest.TestCase):
    def test_give_every_number_a_unit(self):
        for name, schema in all_schemas():
            for key, words in numbers_within(schema):
                with self.subTest(name, key=key):
                    self.assertTrue(UNIT_IN_NAME.search(key) or UNIT_IN_WORDS.search(words), f"{key}: {words}")

    def test_are_schemas_and_their_examples_hold(self):
        for name, schema in all_schemas():
            with self.subTest(name):
                Validator.check_schema(schema)
                self.assertTrue(schema["examples"])
                for example in schema["examples"]:
                    Validator(schema).validate(example)

    def test_know_every_key_and_describe_it(self):
        for name, schema in all_schemas():
            for place in objects_within(schema):
                with self.subTest(name):
                    self.assertIn("additionalProperties", place)
                    for key, value in place["properties"].items():
                        self.assertIn("description", value, key)


class Messages(unittest.TestCase):
    def test_every_stream_and_result_is_emitted(self):
        seen = {(line["schema"], line.get("part")) for line in LINES}
        for name in SCHEMAS:
            part = None if name.startswith("stream.") else "result"
            if name not in ("system.describe", "config.save"):  # produced by the daemon itself
                self.assertIn((name, part), seen)

    def test_what_is_sent_is_as_the_schema_says(self):
        for line in LINES:
            if line.get("part") != "params":
                with self.subTest(line["schema"]):
                    Validator(schema_of(line)).validate(line["value"])

    def test_a_key_more_or_less_is_seen(self):
        for line in LINES:
            if line.get("part") == "params":
                continue
            validator = Validator(schema_of(line))
            self.assertFalse(validator.is_valid({**line["value"], "surplus": 1}), line)
            for key in line["value"]:
                less = copy.copy(line["value"])
                del less[key]
                if key in schema_of(line)["required"]:
                    self.assertFalse(validator.is_valid(less), key)

    def test_params_are_accepted_exactly_if_the_schema_holds(self):
        verdicts = collections.Counter()
        for line in LINES:
            if line.get("part") == "params":
                verdicts[line["schema"], line["valid"]] += 1
                self.assertEqual(Validator(schema_of(line)).is_valid(line["value"]), line["valid"], line)
        self.assertEqual(len(verdicts), 70)  # 35 methods, each accepted and refused
        self.assertGreater(min(verdicts.values()), 30, verdicts)


class WireDocument(unittest.TestCase):
    def test_examples_are_real(self):
        """Blocks marked json hold one message per line: a stream message, a request or a reply."""
        text = (SOURCE / "proto/WIRE.md").read_text()
        seen, method = set(), None
        for block in re.findall(r"```json\n(.*?)```", text, re.DOTALL):
            for line in filter(None, block.splitlines()):
                message = strict(line)
                if "schema" in message:
                    topic = re.fullmatch(r"ovws\.(\w+)/1", message["schema"]).group(1)
                    Validator(SCHEMAS["stream." + topic]).validate(message)
                    seen.add(topic)
                elif "method" in message:
                    method = message["method"]
                elif "result" in message:
                    Validator(SCHEMAS[method]["result"]).validate(message["result"])
                    seen.add("result")
                else:
                    self.assertIn(message["error"]["code"], (
                        -32700, -32600, -32601, -32602, -32603, -32000, -32001, -32002, -32003))
                    self.assertIn("reason", message["error"]["data"])
                    seen.add("error")
        self.assertLessEqual({"wavefront", "spots", "image", "phase", "event", "result", "error"}, seen)

    def test_names_every_method_and_every_key_of_the_streams(self):
        text = (SOURCE / "proto/WIRE.md").read_text()
        for name, schema in SCHEMAS.items():
            if name.startswith("stream."):
                for key in schema["properties"]:
                    self.assertIn(f"`{key}`", text, name)
            else:
                self.assertIn(f"`{name}`", text)
                for key in schema["params"]["properties"]:
                    self.assertIn(f"`{key}", text, name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

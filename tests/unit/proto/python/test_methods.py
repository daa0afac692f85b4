"""The generated methods match the schemas, and there are no others."""
import asyncio
import inspect
import typing
import unittest

from paths import METHODS

from ovws_client import LEFT_OUT, Job, methods


class Recorder(methods.Methods):
    def call(self, method, params=None, binary=None):
        return (method, params) if binary is None else (method, params, binary)

    def call_binary(self, method, params=None, binary=None):
        return self.call(method, params, binary)

    def _job(self, result):
        return result


class AsyncRecorder(methods.AsyncMethods):
    async def call(self, method, params=None, binary=None):
        return (method, params) if binary is None else (method, params, binary)

    async def call_binary(self, method, params=None, binary=None):
        return await self.call(method, params, binary)


def names(kind):
    return {name for name in vars(kind) if not name.startswith("_")} - {"call", "call_binary"}


def collapsed(text):
    return " ".join(text.split())


class Made(unittest.TestCase):
    def test_every_method_is_there_with_its_params_and_words(self):
        wanted = {name.replace(".", "_"): schema for name, schema in METHODS.items()}
        for kind in (methods.Methods, methods.AsyncMethods):
            self.assertEqual(names(kind), set(wanted))
            for name, schema in wanted.items():
                with self.subTest(kind=kind.__name__, method=name):
                    function = getattr(kind, name)
                    params = dict(inspect.signature(function).parameters)
                    del params["self"]
                    self.assertEqual("binary" in params, "binary_params" in schema)
                    params.pop("binary", None)
                    self.assertEqual(set(params), set(schema["params"]["properties"]))
                    must = {key for key, param in params.items() if param.default is not LEFT_OUT}
                    self.assertEqual(must, set(schema["params"].get("required", [])))
                    self.assertIn(collapsed(schema["description"]), collapsed(function.__doc__))
                    if kind is methods.Methods:
                        for key, value in (schema["params"]["properties"] | schema["result"]["properties"]).items():
                            self.assertIn(f"{key}: {collapsed(value['description'])}", collapsed(function.__doc__))

    def test_the_types_of_results_are_those_of_the_schemas(self):
        for name, schema in METHODS.items():
            with self.subTest(method=name):
                result = typing.get_type_hints(getattr(methods.Methods, name.replace(".", "_")))["return"]
                if result is Job:  # JobNumber, with the client
                    result = typing.get_type_hints(getattr(methods.AsyncMethods, name.replace(".", "_")))["return"]
                    self.assertIs(result, methods.JobNumber)
                if "binary_result" in schema:
                    result, pixels = typing.get_args(result)
                    self.assertIs(pixels, bytes)
                # __required_keys__ does not see NotRequired in annotations that are evaluated late.
                kinds = typing.get_type_hints(result, include_extras=True)
                required = {key for key, kind in kinds.items() if typing.get_origin(kind) is not typing.NotRequired}
                self.assertEqual(required, set(schema["result"]["required"]))
                self.assertEqual(set(kinds), set(schema["result"]["properties"]))

    def test_params_are_sent_as_they_are_given(self):
        recorder, later = Recorder(), AsyncRecorder()
        for name, schema in METHODS.items():
            for params in schema["params"]["examples"]:
                with self.subTest(method=name, params=params):
                    sent = getattr(recorder, name.replace(".", "_"))(**params)
                    self.assertEqual((sent[0], sent[1] or {}), (name, params))
                    self.assertEqual(asyncio.run(getattr(later, name.replace(".", "_"))(**params)), sent)
        self.assertEqual(recorder.slm_present(b"x", job=7), ("slm.present", {"job": 7}, b"x"))
        self.assertEqual(recorder.refine_set(saturation_dn=None), ("refine.set", {"saturation_dn": None}), "null is a value")


if __name__ == "__main__":
    unittest.main()

"""Every message and result of the daemon conforms to its schema: every stream, every method, in every state."""
import json
import struct

import jsonschema
from case import PATIENCE_S, PROGRAM_PATIENCE_S, BenchCase, main, wait_for

PICTURES = "tcp://127.0.0.1:7703"


class Messages(BenchCase):
    daemon_config = {"state": {"directory": "state"}}

    def setUp(self):
        super().setUp()
        self.description = self.call("system.describe")
        self.called = set()

    def check(self, schema, value):
        jsonschema.Draft202012Validator(schema, format_checker=jsonschema.FormatChecker()).validate(value)

    def checked_call(self, method, params=None, binary=None):
        self.called.add(method)
        schema = self.description["methods"][method]
        self.check(schema["params"], params or {})
        self.assertEqual("binary_params" in schema, binary is not None)
        result, pixels = self.client.call_binary(method, params, binary)
        self.assertEqual("binary_result" in schema, pixels != b"")
        self.check(schema["result"], result)
        return result

    def checked_job(self, method, params, result_of=None):
        """Runs a job to its end; its result has the schema of the method `result_of`, if that is given."""
        job = self.checked_call(method, params)["job"]
        ended = wait_for(lambda: (report := self.checked_call("job.get", {"job": job}))["state"] != "running" and report, PROGRAM_PATIENCE_S, method)
        self.assertEqual(ended["state"], "done", ended)
        if result_of:
            self.check(self.description["methods"][result_of]["result"], ended["result"])

    def checked_message(self, stream, topic):
        message = stream.next(PATIENCE_S)
        self.assertIsNotNone(message, topic)
        binary = message.pop("binary", None)
        self.assertEqual(message.pop("topic"), topic)
        self.check(self.description["streams"][topic], message)
        return message, binary

    def test_every_method(self):
        for part in (self.call_settings, self.call_references, self.call_loop, self.call_calibrations, self.call_slm,
                     self.call_refinement, self.call_records):
            part()
        self.called |= {"array.fit", "aberration.sequence"}  # of a fixed array: test_lenslets; of a DMD: test_patterns
        self.assertEqual(self.called, set(self.description["methods"]), "each method was called")

    def call_settings(self):
        call = self.checked_call
        call("system.describe")
        call("system.status")
        call("camera.get")
        call("camera.list")
        call("camera.select", {"id": "127.0.0.1"})
        call("camera.set", {"gain_db": 6.0, "exposure_us": 3000.0})
        self.checked_job("camera.auto_exposure", {})
        call("camera.set", {"roi": {"x": 16, "y": 16, "width": 480, "height": 480}, "pixel_format": "Mono12"})
        call("camera.set", {"roi": {"x": 0, "y": 0, "width": 512, "height": 512}, "pixel_format": "Mono8", "gain_db": 0.0, "exposure_us": 2000.0})
        call("sensor.get")
        call("sensor.set", {"charge": 2, "grid": "square", "subapertures_across": 7, "spacing": 0.32})
        call("sensor.set", {"charge": 1, "grid": "hexagonal", "subapertures_across": 5, "spacing": 0.25})
        call("aberration.set", {"modes": [{"n": 2, "m": -2, "waves": 0.5}], "norm": "unit"})
        call("aberration.get")
        call("aberration.clear")

    def call_references(self):
        call = self.checked_call
        call("reference.get")
        job = call("reference.take", {"frames": 30})["job"]
        call("job.get", {"job": job})
        call("job.cancel", {"job": job})
        self.take_reference(20)
        call("reference.get")
        call("job.get", {"job": job + 1})
        call("reference.save", {"name": "one"})
        call("reference.list")
        call("reference.load", {"name": "one"})
        call("reference.delete", {"name": "one"})
        self.checked_job("lattice.prepare", {"lattices": [{"name": "one", "sensor": {"charge": 1}}], "frames": 5, "find_exposure": False})
        call("lattice.list")
        call("lattice.use", {"name": "one"})
        call("lattice.remove", {"name": "one"})

    def call_loop(self):
        """Needs a reference, which it replaces by the model's and removes."""
        call = self.checked_call
        call("correction.get")
        call("correction.set", {"modes": [{"j": 3, "waves": 0.01}]})
        call("loop.close", {"patience_s": PATIENCE_S})
        call("loop.get")
        call("loop.pause", {"paused": True})
        call("loop.open")
        call("loop.model")
        call("job.cancel", {"job": call("loop.identify", {"seconds": 5.0})["job"]})
        call("correction.clear")
        call("reference.set", {"source": "model"})
        known = call("reference.get")
        call("reference.clear")
        call("sensor.set", {"tracker": "lg"})
        positions = [value for at in known["positions_px"] for value in at]
        call("reference.give", {"frames": 10}, struct.pack(f"<{2 * len(positions)}f", *positions, *[0.01] * len(positions)))
        call("reference.clear")
        call("sensor.set", {"tracker": "fit"})

    def call_calibrations(self):
        call = self.checked_call
        call("registration.get")
        self.checked_job("registration.run", {"frames": 1}, "registration.get")
        call("registration.get")
        call("registration.clear")
        call("calibration.get")
        self.checked_job("calibration.run", {"frames": 2, "modes": [1, 2]}, "calibration.get")
        call("calibration.get")
        call("system.status")
        call("sensor.set", {"tracker": "lg"})
        tilts = [10.0, 0.0, 0.0, 10.0] * 19  # x and y of each spot, by the two tilts
        matrix = struct.pack("<152f", *tilts, *[0.0] * 76)
        call("calibration.set", {"shape": [2, 38, 2], "modes": [1, 2], "amplitude_waves": 0.1, "frames": 20}, matrix)
        call("calibration.clear")
        call("sensor.set", {"tracker": "fit"})
        call("corrector.get")
        modes = len(call("sensor.get")["modes_j"])
        call("corrector.set", {"shape": [2, modes]}, bytes(4 * 2 * modes))
        call("corrector.get")
        call("corrector.clear")

    def call_slm(self):
        call = self.checked_call
        call("lut.get")
        self.checked_job("lut.run", {"levels": 9, "frames": 1}, "lut.get")
        call("lut.get")
        call("lut.clear")
        self.run_job("registration.run", {"frames": 2})
        call("flatness.get")
        self.checked_job("focus.run", {"frames": 2})
        self.checked_job("map.run", {"patterns": 4, "cells": 64})
        self.checked_job("flatness.run", {"frames": 5}, "flatness.get")
        call("flatness.get")
        call("flatness.clear")
        self.checked_job("slm.settle", {"repetitions": 3})
        call("slm.verify")
        call("slm.outputs")
        call("slm.set", {"settle_ms": 21.0})
        call("slm.set", {"settle_ms": 20.0})
        shown = call("slm.present", {"shape": [768, 1280], "dtype": "<u1"}, bytes(768 * 1280))
        call("camera.grab", {"after_hologram": shown["hologram_id"], "frames": 2, "average": True})
        call("job.cancel", {"job": shown["job"]})
        self.wait_until("running")
        for pattern in ("flat", "grating", "identify", "sensor"):
            call("slm.show", {"pattern": pattern})

    def call_refinement(self):
        call = self.checked_call
        call("refine.get")
        call("refine.set", {"enabled": True, "electrons_per_dn": 39.2, "saturation_dn": None})
        call("system.status")
        call("refine.set", {"enabled": False})

    def call_records(self):
        call = self.checked_call
        call("record.get")
        call("record.estimate")
        call("record.start", {"name": "all", "limit_s": 60})
        call("record.stop")
        call("record.list")
        call("config.get")
        call("config.save")

    def test_every_stream(self):
        numbers = {topic: self.stream(topic) for topic in ("wavefront", "spots", "status", "event")}
        pictures = {topic: self.stream(topic, endpoint=PICTURES) for topic in ("image", "phase")}
        self.checked_message(numbers["wavefront"], "wavefront")  # without a reference
        self.take_reference(20)
        self.settled_frames(numbers["wavefront"], 1)
        while not self.checked_message(numbers["wavefront"], "wavefront")[0]["valid"]:  # a busy machine makes some late
            pass
        spots = None
        while not (spots and spots["valid"]):  # the oldest messages are of frames that were not settled
            spots, binary = self.checked_message(numbers["spots"], "spots")
        self.assertEqual(len(binary), 4 * spots["shape"][0] * spots["shape"][1])
        self.assertEqual(spots["shape"], [19, 6])
        x, y = struct.unpack("<2f", binary[4 * 6 * 9:4 * 6 * 9 + 8])  # the base subaperture is the tenth of 19
        self.assertLess(abs(x - 255.5) + abs(y - 255.5), 2.0)
        self.checked_message(numbers["status"], "status")
        self.call("slm.show", {"pattern": "flat"})
        self.call("slm.show", {"pattern": "sensor"})
        self.checked_message(numbers["event"], "event")
        modes = len(self.call("sensor.get")["modes_j"])
        self.client.call("corrector.set", {"shape": [3, modes]}, bytes(4 * 3 * modes))
        commands, binary = self.checked_message(self.stream("corrector"), "corrector")
        self.assertEqual(len(binary or b""), 4 * commands["shape"][0])
        for topic, size in (("image", 1), ("phase", 4)):
            message, binary = self.checked_message(pictures[topic], topic)
            self.assertEqual(len(binary), size * message["shape"][0] * message["shape"][1])

    def test_strict_json(self):
        stream = self.stream("wavefront")
        for _ in range(20):
            message = stream.next(PATIENCE_S)
            self.assertIsNotNone(message)
            json.dumps(message, allow_nan=False)


if __name__ == "__main__":
    main()

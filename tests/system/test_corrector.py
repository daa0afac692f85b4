"""An external corrector: a client's matrix turns frames into commands, and its own pokes calibrate the sensor."""
import os
import subprocess
import sys
import time

from case import PATIENCE_S, ROOT, BenchCase, ClientError, bench_module, main, message_since, next_message, wait_for

import numpy as np

from ovws_client import Corrector, MirrorLoop, calibrate_sensor, set_matrix

EXAMPLE = ROOT / "proto" / "python" / "examples" / "mirror_loop.py"
PYTHON = bench_module.find_programs().parent / "python"


class CorrectorCase(BenchCase):
    small = True
    daemon_config = {"state": {"directory": "state"}}

    def drive(self, waves, first_j=1):
        """A perfect mirror, whose actuators are the modes from `first_j` on."""
        self.twin.call("twin.set", {"aberration": [{"j": first_j + k, "waves": float(value)} for k, value in enumerate(waves)]})

    def refused_field(self, method, params, binary=None):
        with self.assertRaises(ClientError) as caught:
            self.client.call(method, params, binary)
        return caught.exception.data["field"]


class Commands(CorrectorCase):
    def test_from_the_matrix_to_the_restart(self):
        self.take_reference(20)
        known = self.call("corrector.get")
        self.assertEqual((known["active"], known["matrix"], known["modes_j"]), (False, None, []))
        modes = len(self.call("sensor.get")["modes_j"])
        matrix = np.random.default_rng(1).standard_normal((69, modes)).astype("f4")
        stream, events = self.stream("wavefront", "corrector"), self.stream("event")
        known = set_matrix(self.client, matrix)
        self.assertEqual((known["active"], known["reason"], known["actuators"], len(known["modes_j"])), (True, None, 69, modes))
        event = wait_for(lambda: (e := events.next(1.0)) and e["kind"] == "corrector" and e, what="the event")
        self.assertEqual(event["data"]["actuators"], 69)
        self.drive([0.1, 0.0, 0.05])
        self.commands_belong_to_the_modes(stream, matrix, known["matrix"])
        self.nothing_half_applied(known, modes)
        self.other_modes(known, events)
        self.bench.stop("ovwsd")
        self.client.close()
        self.start_daemon()
        self.wait_until("running")
        self.assertIsNone(self.call("corrector.get")["matrix"], "the client sets it again")

    def commands_belong_to_the_modes(self, stream, matrix, number):
        commands, compared = {}, 0
        while compared < 50:
            message = next_message(stream)
            if message["topic"] == "corrector":
                self.assertEqual((message["matrix"], message["shape"]), (number, [69] if message["valid"] else [0]))
                commands[message["frame_id"]] = message
                continue
            given = commands.get(message["frame_id"])
            if given is None:  # the matrix was not set yet
                continue
            self.assertEqual(given["valid"], message["valid"])
            self.assertEqual("binary" in given, message["valid"])
            self.assertEqual((given["t_arrival_ns"], given["hologram_id"]), (message["t_arrival_ns"], message["hologram_id"]))
            self.assertLessEqual(given["t_publish_ns"], message["t_publish_ns"])
            if message["valid"]:
                due = matrix @ np.array(message["coefficients"], "f4")
                np.testing.assert_allclose(np.frombuffer(given["binary"], "<f4"), due, atol=1e-5)
                compared += 1

    def nothing_half_applied(self, known, modes):
        """What does not fit is refused by the field at fault, and the matrix stays."""
        row = bytes(4 * modes)
        for field, params, binary in (("shape", {}, row), ("shape", {"shape": [1]}, row), ("shape[0]", {"shape": [0, modes]}, b""),
                                      ("shape[0]", {"shape": [4097, modes]}, 4097 * row), ("shape", {"shape": [1, modes + 1]}, row + bytes(4)),
                                      ("matrix", {"shape": [2, modes]}, row), ("matrix", {"shape": [1, modes]}, None),
                                      ("matrix", {"shape": [1, modes]}, np.full(modes, np.nan, "<f4").tobytes()),
                                      ("unit", {"shape": [1, modes], "unit": "V"}, row)):
            with self.subTest(params=params):
                self.assertEqual(self.refused_field("corrector.set", params, binary), field)
        self.assertEqual(self.call("corrector.get"), known)

    def other_modes(self, known, events):
        """Without its modes the matrix stays, but gives no commands; and again, when they return. The loop of the SLM is none of its business."""
        self.close_loop(gain=0.1)
        self.assertTrue(self.call("corrector.get")["active"])
        self.call("loop.open", {"keep": False})
        before = self.call("sensor.get")["subapertures_across"]
        self.call("sensor.set", {"subapertures_across": before + 2})
        inactive = self.call("corrector.get")
        self.assertEqual((inactive["active"], inactive["matrix"]), (False, known["matrix"]))
        self.assertIn("corrector.set", inactive["reason"])
        warning = wait_for(lambda: (e := events.next(1.0)) and e["kind"] == "corrector" and e["severity"] == "warning" and e, what="the warning")
        self.assertIn("corrector.set", warning["text"])
        stream = self.stream("corrector")
        self.assertFalse(message_since(stream, time.time_ns())["valid"])
        self.call("sensor.set", {"subapertures_across": before})
        self.assertTrue(self.call("corrector.get")["active"])
        wait_for(lambda: (message := stream.next(1.0)) and message["valid"], what="commands again")
        self.assertFalse(self.call("corrector.clear")["active"])
        both = self.stream("wavefront", "corrector")
        message_since(both, time.time_ns())
        self.assertEqual({next_message(both)["topic"] for _ in range(20)}, {"wavefront"})


class Killed(CorrectorCase):
    twin_config = {"mirror": {"actuators_across": 9}}

    def shown(self):
        return self.twin.call("twin.get")["mirror"]["waves"]

    def test_a_killed_client_leaves_the_mirror_and_another_one_continues(self):
        """The example closes the loop; killed, the mirror stays where it is and the daemon goes on measuring."""
        self.take_reference(20)
        env = os.environ | {"PYTHONPATH": str(PYTHON)}
        client = subprocess.Popen([sys.executable, "-u", str(EXAMPLE), "600"], stdout=subprocess.PIPE, text=True, env=env)
        self.addCleanup(client.stdout.close)
        self.addCleanup(client.wait)
        self.addCleanup(client.kill)
        open_waves = float(client.stdout.readline().split()[2])
        self.assertAlmostEqual(open_waves, 0.112, delta=0.02)
        stream = self.stream("wavefront", "corrector")
        wait_for(lambda: all(self.residual(stream) < 0.01 for _ in range(5)), what="0.01 wave RMS")
        client.kill()
        client.wait()
        stands, events = wait_for(lambda: (shown := self.shown()) == self.shown() and shown, what="the client's last command"), self.stream("event")
        message_since(stream, time.time_ns())
        frames = []

        def went_on():
            frames.append(next_message(stream))
            return all(sum(f["topic"] == topic and f["valid"] for f in frames) > 15 for topic in ("corrector", "wavefront"))
        wait_for(went_on, what="commands and wavefronts that go on")
        self.assertEqual(self.shown(), stands, "the mirror stays")
        self.assertGreater(max(map(abs, stands)), 0.05)
        measured = [f["rms_waves"] for f in frames if f["topic"] == "wavefront" and f["valid"]]
        self.assertLess(max(measured) - min(measured), 0.01, "and so does the measurement")
        self.assertEqual([e for e in iter(lambda: events.next(0.0), None) if e["kind"] == "corrector"], [])
        # Another client corrects by the modes of the twin's hidden aberration; the mirror keeps what it shows.
        modes = len(self.call("sensor.get")["modes_j"])
        number = set_matrix(self.client, np.eye(modes))["matrix"]
        start = np.zeros(modes)
        start[2], start[6], start[3] = 0.1, -0.05, 0.1  # the last is defocus, which came in between
        self.drive(start)
        loop = MirrorLoop(self.drive, modes, gain=0.3, start=start, matrix=number)
        wait_for(lambda: loop.run(self.client, seconds=2.0, timeout_s=PATIENCE_S) or self.residual(stream) < 0.01, what="0.01 wave RMS")
        with self.client.subscribe(Corrector) as commands:
            self.assertEqual(commands.next(PATIENCE_S).matrix, number)

    def residual(self, stream):
        """RMS of the next valid wavefront, waves."""
        stream.drain()
        return wait_for(lambda: (m := stream.next(1.0)) and m["topic"] == "wavefront" and m["valid"] and m)["rms_waves"]


class Calibration(CorrectorCase):
    def in_use(self):
        sensor = self.call("sensor.get")
        return sensor["operator"], sensor["operator_in_force"], sensor["operator_reason"]

    def test_a_mirror_calibrates_the_sensor(self):
        modes = list(range(1, 11))
        self.assertEqual(self.refused_field("calibration.set", {"shape": [2, 38, 1], "modes": [1], "amplitude_waves": 0.1, "frames": 2}, bytes(304)), "tracker")
        self.call("sensor.set", {"tracker": "lg"})
        self.take_reference(20)
        known = calibrate_sensor(self.client, self.drive, modes, np.eye(10), amplitude_waves=0.1, frames=10)
        self.assertEqual((known["source"], known["in_force"], known["amplitude_waves"], known["frames"]), ("set", True, 0.1, 10))
        self.assertEqual([mode["j"] for mode in known["modes"]], modes)
        for mode in known["modes"]:
            self.assertAlmostEqual(mode["factor"], 1.0, delta=0.1, msg=mode)
        self.assertEqual(self.in_use(), ("measured", "measured", None))
        self.drive([0.0, 0.0, 0.1])
        stream = self.stream("wavefront")
        frame = wait_for(lambda: (m := stream.next(1.0)) and m["valid"] and abs(m["coefficients"][2] - 0.1) < 0.005 and m, what="0.1 wave of j = 3")
        self.assertEqual(frame["j"], modes)
        self.refusals(known)
        self.bench.stop("ovwsd")
        self.client.close()
        self.start_daemon(tracking={"operator": "measured", "tracker": "lg"})
        self.wait_until("running")
        self.assertEqual(self.call("calibration.get"), known)
        self.assertFalse(self.call("calibration.clear")["calibrated"])

    def refusals(self, known):
        tilts = np.zeros((2, 38, 2), "<f4")
        tilts[0, 0::2, 0] = tilts[0, 1::2, 1] = 10.0

        def given(field, matrix=tilts, **params):
            params = {"shape": list(matrix.shape), "modes": [1, 2], "amplitude_waves": 0.1, "frames": 20} | params
            params = {key: value for key, value in params.items() if value is not None}
            self.assertEqual(self.refused_field("calibration.set", params, matrix.tobytes()), field)

        def changed(where, value):
            matrix = tilts.copy()
            matrix[where] = value
            return matrix

        given("shape", shape=[2, 36, 2])
        given("shape", shape=[38, 2])
        given("shape", shape=None)
        given("shape", modes=[1, 2, 3])
        given("modes", modes=[2, 1])
        given("modes", modes=[1, 60])
        given("modes", modes=[1, 1])
        given("modes", modes=None)
        given("amplitude_waves", amplitude_waves=0.0)
        given("frames", frames=None)
        given("matrix", tilts[:, :, :1], shape=[2, 38, 2])
        given("matrix", changed((0, 3, 1), np.nan))
        given("matrix", 1e8 * tilts)
        given("matrix", changed((1, 3, 1), -1.0))
        given("matrix", changed((1, slice(None), 0), 2.0))
        given("matrix", changed((0, slice(None), 1), tilts[0, :, 0]))
        given("matrix", changed((0, slice(4, None)), 0.0))
        self.assertEqual(self.call("calibration.get"), known)


if __name__ == "__main__":
    main()

"""The Tango device server with a real Tango client: reads, sets, commands, events, a restarted daemon, two servers."""
import json
import re
import subprocess
import sys
import threading
import time
from contextlib import suppress

from bridge_case import BridgeCase, Path, environment
from case import PATIENCE_S, PROGRAM_PATIENCE_S, ROOT, main, next_message, wait_for

import numpy as np
import tango

NAME = "ovws/bench/1"
VALID = tango.AttrQuality.ATTR_VALID
EVENTS = Path(__file__).with_name("tango_events.py")


class Events:
    """A process that has subscribed, and the events that it has received so far."""

    def __init__(self, test, device, *names):
        self._process = subprocess.Popen([sys.executable, EVENTS, device, *names], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                         stderr=subprocess.PIPE, text=True, env=environment())
        self.received = []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()
        test.addCleanup(self.end)
        test.assertIn("subscribed\n", iter(self._process.stderr.readline, ""))

    def _read(self):
        for line in self._process.stdout:
            if line.startswith("{"):
                self.received.append(json.loads(line))

    def of(self, name):
        return [event for event in self.received if event["name"] == name]

    def wait_for(self, condition, what):
        wait_for(lambda: condition(self), what=what)

    def end(self):
        if self._process.stdin.closed:
            return
        self._process.stdin.close()
        self._process.wait(PROGRAM_PATIENCE_S)
        self._reader.join()
        self._process.stdout.close()
        self._process.stderr.close()


class Server(BridgeCase):
    def start(self):
        super().start()
        self.device = self.serve("bench", 45450, "--max-event-rate-hz", "1000")  # frames that a busy machine delivers late come together
        self.attribute("rms_waves")  # the first frame
        wait_for(lambda: self.device.state() == tango.DevState.ON, what="the first status")

    def serve(self, instance, port, *options):
        """Starts a server; returns its device as a client sees it."""
        self.start_bridge("tango", instance, *options, "-nodb", "-dlist", NAME, "-ORBendPoint", f"giop:tcp:127.0.0.1:{port}", ready="Ready", name=f"tango {instance}")
        device = tango.DeviceProxy(f"tango://127.0.0.1:{port}/{NAME}#dbase=no")
        wait_for(lambda: self.answers(device), what=f"the server {instance}")
        device.set_timeout_millis(int(1e3 * PATIENCE_S))
        return device

    @staticmethod
    def answers(device):
        with suppress(tango.DevFailed):
            return device.ping() >= 0
        return False

    def attribute(self, name, quality=VALID):
        """An attribute, when it has this quality."""
        return wait_for(lambda: (read := self.device.read_attribute(name)).quality == quality and read, what=f"{name} {quality}")

    def events(self, *names, port=45450):
        return Events(self, f"tango://127.0.0.1:{port}/{NAME}#dbase=no", *names)

    def test_frames_as_attributes(self):
        self.assertIn("running", self.device.status())
        self.call("aberration.set", {"modes": [{"j": 4, "waves": 0.1}]})
        wait_for(lambda: abs(self.attribute("coefficients").value[3] - 0.1) < 0.005, what="the aberration")
        names = ["coefficients", "rms_waves", "valid", "j", "frame_id", "t_arrival_ns"]
        read = wait_for(lambda: (r := self.device.read_attributes(names))[0].quality == r[1].quality == VALID and r[2].value and r, what="a valid frame")
        self.assertEqual(len(read[0].value), len(read[3].value))
        self.assertAlmostEqual(read[1].value, 0.1, delta=0.005)
        self.assertAlmostEqual(read[0].time.totime(), time.time(), delta=60.0)
        self.assertAlmostEqual(1e-9 * read[5].value, read[5].time.totime(), delta=1e-4)
        (image,), phase = wait_for(self.image, what="an image"), self.attribute("phase").value
        self.assertEqual((image.shape, phase.shape), ((512, 512), (128, 128)))
        self.assertGreater(image.max(), 20)
        self.assertAlmostEqual(float(np.nanstd(phase)), 0.1, delta=0.01)

    def image(self):
        """A list of an image, empty if a busy machine has none within the server's 2 s."""
        with suppress(tango.DevFailed):
            return [self.device.image]
        return []

    def test_the_guide_names_what_there_is(self):
        guide = (ROOT / "daemon" / "guide" / "bridges.md").read_text()
        self.assertIn(f"python3 -m ovws_bridges.tango bench -nodb -dlist {NAME} -ORBendPoint giop:tcp:127.0.0.1:45450", guide)
        tango_part = guide.split("## Tango")[1].split("## EPICS")[0]
        rows = re.findall(r"^\| (`.*?) \|", tango_part, re.MULTILINE)
        self.assertEqual({name for row in rows for name in re.findall(r"`(\w+)`", row)}, set(self.device.get_attribute_list()) - {"State", "Status"})
        commands = set(self.device.get_command_list()) - {"Init", "State", "Status"}
        self.assertLessEqual(commands, set(re.findall(r"`(\w+)`", tango_part.split("- Commands:")[1])))

    def test_documentation_comes_from_the_field_tables(self):
        wire, camera = self.schema("wavefront")["properties"], self.schema("camera.set")["properties"]
        for name, unit in (("coefficients", "wave"), ("rms_waves", "wave"), ("valid", ""), ("frame_id", ""), ("t_arrival_ns", "ns")):
            config = self.device.get_attribute_config(name)
            self.assertEqual((config.description, config.unit), (wire[name]["description"], unit))
        for name in ("exposure_us", "gain_db"):
            config = self.device.get_attribute_config(name)
            limits = float(config.min_value), float(config.max_value)
            self.assertEqual((config.description, *limits), (camera[name]["description"], camera[name]["minimum"], camera[name]["maximum"]))

    def test_settings_and_commands(self):
        self.device.exposure_us = 1500.0
        self.device.aberration = [0.0, 0.0, 0.0, 0.1]
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 1500.0)
        self.assertEqual([(mode["j"], mode["waves"]) for mode in self.call("aberration.get")["modes"] if mode["waves"]], [(4, 0.1)])
        self.assertEqual(self.device.aberration[3], 0.1)
        wait_for(lambda: self.device.exposure_us == 1500.0, what="the exposure in use")
        self.device.aberration_clear()
        self.assertEqual(self.call("aberration.get")["modes"], [])
        job = self.device.reference_take(20)
        wait_for(lambda: json.loads(self.device.call(["job.get", json.dumps({"job": job})]))["state"] == "done", what="the reference")
        self.attribute("rms_waves")
        self.device.loop_close()
        self.assertEqual(self.call("system.status")["loop"], "closed")
        self.device.loop_open()
        self.assertEqual(self.call("system.status")["loop"], "open")
        self.device.Init()
        self.attribute("rms_waves")
        self.assertEqual(self.device.aberration.max(), 0.0)

    def refused_with(self, work):
        with self.assertRaises(tango.DevFailed) as caught:
            work()
        return caught.exception.args[0]

    def test_refusals_pass_on_the_daemons_reason(self):
        for name, value, reason in (("gain_db", 90.0, "gain_db: 90 is outside the camera's range of 0 to"), ("aberration", [1e6], "must be a number from -1000 to 1000")):
            error = self.refused_with(lambda name=name, value=value: self.device.write_attribute(name, value))
            self.assertEqual(error.reason, "OVWS_Refused")
            self.assertIn(reason, error.desc)
        error = self.refused_with(lambda: self.device.write_attribute("exposure_us", 1e9))
        self.assertEqual(error.reason, "API_WAttrOutsideLimit", "Tango checks the range of the field table itself")
        self.assertIn("did you mean", self.refused_with(lambda: self.device.call(["camera.set", '{"gain": 1}'])).desc)
        self.assertIn("must be JSON", self.refused_with(lambda: self.device.call(["camera.set", "gain"])).desc)

    def test_events_of_every_frame_up_to_the_rate(self):
        slow = self.serve("slow", 45451, "--max-event-rate-hz", "10")
        wait_for(lambda: slow.state() == tango.DevState.ON, what="the second server")
        frames = self.stream("wavefront")
        next_message(frames)
        fast, limited = self.events("seq", "coefficients"), self.events("seq", port=45451)
        fast.wait_for(lambda events: len(events.of("seq")) > 50, "50 events")
        self.call("reference.clear")
        fast.wait_for(lambda events: events.of("coefficients")[-1]["quality"] == "INVALID" and len(events.of("seq")) > 100, "100 events, the last ones without a reference")
        limited.wait_for(lambda events: len(events.received) > 25, "25 events at the limited rate")
        for events in (fast, limited):
            events.end()
        seq = [event["value"] for event in fast.of("seq")]
        seq = list(dict.fromkeys(seq[1:5])) + seq[5:]  # a subscription reads a value, which may come as an event, too
        self.assertEqual(set(np.diff(seq)), {1}, "no frame is missing")
        messages = [next_message(frames)]
        while messages[-1]["seq"] <= seq[-1]:
            messages.append(next_message(frames))
        for event in fast.of("coefficients")[1:]:
            message = min(messages, key=lambda message: abs(1e-9 * message["t_arrival_ns"] - event["time"]))
            self.assertAlmostEqual(1e-9 * message["t_arrival_ns"], event["time"], delta=1e-4)
            self.assertEqual(event["quality"], "VALID" if message["valid"] else "INVALID", message)
        # 10 events a second, of 50 frames; two more at once after a pause.
        seq = [event["value"] for event in limited.received]
        self.assertLessEqual(len(seq), 10.0 * (limited.received[-1]["after_s"] + 0.2) + 2)
        self.assertGreaterEqual(slow.lost, seq[-1] - seq[0] - (len(seq) - 1), "frames without an event are counted")
        self.assertEqual(self.device.lost, 0)
        self.assertFalse(self.attribute("valid").value)

    def test_it_outlives_the_daemon_and_leaves_nothing(self):
        watching = self.events("State", "rms_waves")
        self.bench.stop("ovwsd")
        watching.wait_for(lambda events: "UNKNOWN" in [event["value"] for event in events.of("state")], "the state UNKNOWN")
        watching.wait_for(lambda events: "INVALID" in [event["quality"] for event in events.of("rms_waves")], "an invalid attribute")
        self.assertEqual(watching.of("state")[0]["value"], "ON")
        watching.end()
        self.attribute("rms_waves", tango.AttrQuality.ATTR_INVALID)
        self.attribute("exposure_us", tango.AttrQuality.ATTR_INVALID)
        self.assertEqual(self.device.state(), tango.DevState.UNKNOWN)
        self.assertIn("does not answer", self.device.status())
        self.assertEqual(self.refused_with(lambda: self.device.write_attribute("exposure_us", 700.0)).reason, "OVWS_NoAnswer")
        returning = self.events("exposure_us")
        self.restart_daemon()
        self.attribute("rms_waves")
        wait_for(lambda: self.device.state() == tango.DevState.ON, what="the state ON")
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 2000.0, "what was given up is not carried out later")
        returning.wait_for(lambda events: [event["quality"] for event in events.received][-2:] == ["INVALID", "VALID"], "the valid exposure")
        returning.end()
        device = self.bench.process("tango bench").popen
        connections = self.connections(device.pid)
        self.assertTrue(self.daemon_has(connections), connections)
        device.kill()
        wait_for(lambda: not self.daemon_has(connections), what="the end of its connections")
        self.wait_until("running")


if __name__ == "__main__":
    main()

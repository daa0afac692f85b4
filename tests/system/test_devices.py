"""Another camera and another SLM output are chosen at run time, and what cannot be used is refused with the reason."""
import json
import signal
import subprocess

from case import SMALL_DAEMON, SMALL_TWIN, BenchCase, main, merged, wait_for

OTHER = "127.0.0.2"


class Devices(BenchCase):
    small = True
    daemon_config = {"state": {"directory": "state"}}

    def frames_come(self):
        stream = self.stream("wavefront")
        wait_for(lambda: (frame := stream.next(0.5)) and frame["settled"], what="a settled frame")

    def output(self):
        return self.call("system.status")["slm"]["info"]["output"]

    def xrandr(self, *arguments):
        subprocess.run(["xrandr", "-display", self.bench.display, *arguments], check=True, capture_output=True)

    def test_outputs(self):
        self.take_reference(20)
        listed = {output["name"]: output for output in self.call("slm.outputs")["outputs"]}
        print("\n ", json.dumps(listed))
        self.assertEqual([name for name, one in listed.items() if one["selected"]], ["DUMMY1"])
        self.assertEqual((listed["DUMMY1"]["usable"], listed["DUMMY1"]["reason"], listed["DUMMY1"]["width"], listed["DUMMY1"]["on"]), (True, None, 640, True))
        self.assertTrue(listed["DUMMY0"]["primary"])
        self.assertIn("primary", listed["DUMMY0"]["reason"])
        hologram = self.call("system.status")["slm"]["hologram_id"]
        for params, field, reason in (({"display": "HDMI-9"}, "slm.display", "there are: DUMMY0"), ({"display": "DUMMY0"}, "slm.display", "primary"),
                                      ({"display": "DUMMY0", "allow_primary": True, "settle_ms": 33.0}, "slm.width", "1920x1080"), ({"display": ""}, "display", "empty"),
                                      ({"settle_ms": -1.0}, "settle_ms", "0")):
            with self.subTest(params):
                error = self.refused("slm.set", params)
                self.assertEqual(error.data["field"], field)
                self.assertIn(reason, str(error))
        self.assertEqual(self.call("slm.set"), {"display": "DUMMY1", "allow_primary": False, "settle_ms": 20.0})
        self.assertEqual(self.call("system.status")["slm"]["hologram_id"], hologram)
        self.frames_come()
        self.check_other_output()

    def check_other_output(self):
        self.xrandr("--newmode", "small", "79.5", "640", "656", "720", "800", "384", "386", "390", "400")
        self.xrandr("--addmode", "DUMMY0", "small")
        self.xrandr("--output", "DUMMY0", "--mode", "small")
        self.wait_until("running")
        self.assertEqual(self.call("slm.set", {"display": "DUMMY0", "allow_primary": True, "settle_ms": 15.0}),
                         {"display": "DUMMY0", "allow_primary": True, "settle_ms": 15.0})
        self.assertEqual(self.output(), "DUMMY0")
        self.assertTrue(self.call("slm.verify")["equal"])
        self.assertEqual(self.call("config.save")["saved"], ["slm.allow_primary", "slm.display", "slm.settle_ms"])
        self.assertEqual(self.call("config.get")["slm"]["display"], "DUMMY0")
        self.bench.stop("ovwsd")
        self.start_daemon()
        self.wait_until("running")
        self.assertEqual(self.output(), "DUMMY0")
        self.check_reload()

    def check_reload(self):
        """The configuration file's output is used again once it is edited there; one that does not exist changes nothing."""
        events = self.stream("event")
        for display, reloaded in (("HDMI-9", False), ("DUMMY1", True)):
            config = merged(merged(SMALL_DAEMON, self.daemon_config), {"slm": {"display": display, "settle_ms": 21.0, "allow_primary": True}})
            (self.bench.directory / "ovwsd.json").write_text(json.dumps(config))
            self.bench.process("ovwsd").popen.send_signal(signal.SIGHUP)
            event = wait_for(lambda: (event := events.next(0.5)) and event["kind"] == "config" and event, what="the reload's end")
            self.assertEqual(event["data"]["reloaded"], reloaded, event)
            self.assertEqual(self.output(), "DUMMY1" if reloaded else "DUMMY0")
        self.assertIn("slm.display", event["data"]["applied"])
        self.settled_frames(self.stream("wavefront"), 5)  # measured against the kept reference

    def start_other_camera(self):
        subprocess.run(["ip", "address", "add", f"{OTHER}/8", "dev", "lo"], check=True)
        path = self.bench._write("other.json", merged(SMALL_TWIN, {"noise": "pool"}))
        twin = self.bench.start("other-twin", [self.bench.programs / "ovws-twin", "--config", path, "--address", OTHER, "--control", "tcp://127.0.0.1:7791"],
                                env=self.bench._environment())
        twin.wait_for_line("ready")

    def test_cameras(self):
        # On a busy machine a camera may not answer in the second that a search takes.
        listed = wait_for(lambda: [one for one in self.call("camera.list")["cameras"] if one["address"] == "127.0.0.1"], what="the camera")
        print("\n ", listed)
        self.assertEqual([one["selected"] for one in listed], [True])
        for id, reason in (("Nobody-1234", "there are: "), ("127.0.0.77", "no camera answers")):
            error = wait_for(lambda id=id, reason=reason: reason in str(error := self.refused("camera.select", {"id": id})) and error, what=reason)
            self.assertEqual(error.data["field"], "camera.id")
        self.assertEqual(self.refused("camera.select").data["field"], "id")
        self.assertEqual(self.call("system.status")["counters"]["camera_reconnects"], 0, "a refusal leaves the camera alone")
        self.start_other_camera()
        self.call("camera.set", {"exposure_us": 1500.0})
        chosen = self.call("camera.select", {"id": OTHER})
        self.assertEqual((chosen["info"]["address"], chosen["settings"]["exposure_us"]), (OTHER, 1500.0))
        self.wait_until("running")
        self.frames_come()
        self.assertIn("camera.id", self.call("config.save")["saved"])
        self.check_absent()

    def check_absent(self):
        """A camera that is switched on later is selected with `wait`, and the first one is taken back."""
        absent = self.call("camera.select", {"id": "127.0.0.3", "wait": True})
        self.assertFalse(absent["connected"])
        self.assertEqual(self.call("system.status")["state"], "waiting_for_camera")
        self.assertTrue(self.call("camera.select", {"id": "127.0.0.1"})["connected"])
        self.wait_until("running")
        self.frames_come()
        self.take_reference(20)
        self.close_loop()
        self.assertIn("loop", str(self.refused("camera.select", {"id": "127.0.0.1"})))
        self.assertIn("loop", str(self.refused("slm.set", {"settle_ms": 5.0})))
        self.call("loop.open")


if __name__ == "__main__":
    main()

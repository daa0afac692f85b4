"""ovws setup on a terminal: a bench with five faults ends with a flat wavefront, a wrong output is found and replaced."""
import json
import os
import random
import re
import subprocess

from case import PROGRAM_PATIENCE_S, SMALL_SIZE, BenchCase, main, wait_for
from conversation import on, talk, transcript
from terminal import Terminal

MODES = range(3, 15)
MOST_WAVES = 0.01
CENTRE_PX = [(size - 1) / 2 for size in SMALL_SIZE]
PITCH_PX = SMALL_SIZE[1] / 5


def hidden_aberration(rms_waves):
    rng = random.Random(1)
    modes = {j: rng.gauss(0.0, 1.0) for j in MODES}
    scale = rms_waves / sum(waves * waves for waves in modes.values()) ** 0.5
    return [{"j": j, "waves": scale * waves} for j, waves in modes.items()]


class SetupCase(BenchCase):
    small = True

    def start(self):
        self.start_display()
        self.add_output()
        self.start_twin()
        self.start_daemon(**{"state": {"directory": str(self.bench.directory / "state")}})
        wait_for(lambda: self.call("camera.get")["connected"], what="the camera")
        wait_for(lambda: self.call("system.status")["state"] in ("running", "fault"), what="the SLM's output, or why it is not used")

    def add_output(self):
        """A third output of the SLM's size, which the twin does not watch."""
        mode = f"{SMALL_SIZE[0]}x{SMALL_SIZE[1]}"
        for words in (["--addmode", "DUMMY2", mode], ["--output", "DUMMY2", "--mode", mode, "--right-of", "DUMMY1"]):
            subprocess.run(["xrandr", *words], env=os.environ | {"DISPLAY": self.bench.display}, check=True)

    def set_up(self, *arguments, answer=on, status=0):
        """Answers the questions of ovws setup; returns the transcript."""
        command = self.ovws_command("setup", "--config", self.bench.directory / "ovwsd.json", *arguments)
        terminal = Terminal(command, columns=200, DISPLAY=self.bench.display)
        self.addCleanup(terminal.close)
        ended = talk(terminal, answer)
        self.assertEqual(ended, status, transcript(terminal))
        return transcript(terminal)

    def states(self):
        done = self.run_ovws("--json", "setup", "--list", check=True)
        document = json.loads(done.stdout)
        self.assertEqual(document["schema"], "ovws.commission/1")
        return {step["name"]: step["state"] for step in document["steps"]}


# A rotated and mirrored camera, a far too long exposure, an SLM whose phase falls, and half a wave of hidden aberration.
FAULTS = {"camera": {"mirror": "x", "rotation_deg": 30.0}, "slm": {"depth_waves": -1.0}, "aberration": hidden_aberration(0.5),
          "light": {"peak_electrons": 60000}}
# As long as the frame rate allows. Until the settle time is measured, it is one with which a busy machine's twin sees a hologram.
TOO_LONG = {"camera": {"exposure_us": 9900.0}, "slm": {"settle_ms": 60}}


class FiveFaults(SetupCase):
    twin_config = FAULTS
    daemon_config = TOO_LONG

    def test_ends_with_a_flat_wavefront(self):
        text = self.set_up()
        self.assertIn("The phase falls with the grey level", text)
        self.assertIn("mirrored;", text)
        self.assertNotIn("not mirrored", text)
        self.assertIn("Next: ovws check", text)
        left = self.twin.call("twin.get", {"judge": "sensor"})["wavefront"]
        self.assertTrue(left["unwrapped"], text)
        self.assertLess(left["rms_waves"], MOST_WAVES)
        self.check_that_it_resumes()
        self.check_that_the_loop_is_restored()

    def check_that_it_resumes(self):
        """Another commissioning finds what is done, and an undone step is the only measured one that is open."""
        states = self.states()
        self.assertEqual({name for name in states if states[name] != "done"}, {"loop", "save"})
        listed = self.run_ovws("setup", "--list", check=True).stdout
        self.assertRegex(listed, r"(?m)^done +doctor ")
        self.assertRegex(listed, r"(?m)^not recorded +save ")
        self.assertIn("the daemon keeps nothing that tells", listed)
        # before the reference is run again: undo it; then run it; then y, which has nothing to repair; then Ctrl-D, which quits
        answers = iter("u\ny\x04")
        text = self.set_up("--from", "reference", answer=lambda question: next(answers))
        self.assertEqual(text.count("Taken from 100 frames"), 1, text)
        self.assertIn("The reference is cleared.", text)
        states = self.states()
        for name in ("registration", "lut", "flatness", "clear", "reference", "calibration"):
            self.assertEqual(states[name], "done", states)

    def check_that_the_loop_is_restored(self):
        """The step leaves a closed loop and an aberration as they were; a reference from the model is none that was taken."""
        self.call("aberration.set", {"modes": [{"j": 5, "waves": 0.05}]})
        self.close_loop(gain=0.3)
        self.assertIn("The loop is closed again, as before.", self.set_up("--yes", "loop"))
        loop = self.call("loop.get")
        self.assertEqual((loop["closed"], loop["gain"]), (True, 0.3))
        [mode] = self.call("aberration.get")["modes"]
        self.assertEqual((mode["j"], round(mode["waves"], 9)), (5, 0.05))
        self.call("loop.open", {"keep": False})
        self.call("reference.set", {"source": "model"})
        self.assertEqual(self.states()["reference"], "open")


class WrongOutput(SetupCase):
    daemon_config = {"slm": {"display": "DUMMY2"}}

    def test_is_named_and_replaced(self):
        text = self.set_up("camera", "output", "spot")
        self.assertIn("BAD: The camera's image does not change with what DUMMY2 shows.", text)
        self.assertIn("use output DUMMY1 for the SLM", text)
        self.assertIn("good: The camera's image changes with what DUMMY1 shows", text)
        self.assertIn("The base grating makes one spot", text)
        self.assertEqual(self.call("system.status")["slm"]["info"]["output"], "DUMMY1")


class NarrowRegion(SetupCase):
    """As narrow as the spots, which reach farther in y than in x."""
    daemon_config = {"camera": {"roi": {"x": 104, "y": 0, "width": 304, "height": 512}}}

    def check_config(self):
        config = self.bench.directory / "as_used.json"
        config.write_text(json.dumps(self.call("config.get")))
        return subprocess.run([self.bench.programs / "ovwsd", "--check-config", "--config", config], capture_output=True, timeout=PROGRAM_PATIENCE_S).returncode

    def test_the_step_and_check_config_agree(self):
        self.assertEqual(self.check_config(), 0)
        text = self.set_up("spot")
        self.assertIn("good: The base grating makes one spot", text)
        self.assertNotIn("beyond the region", text)
        self.call("camera.set", {"roi": {"x": 104, "y": 76, "width": 304, "height": 360}})
        self.assertEqual(self.check_config(), 1)
        text = self.set_up("spot")
        self.assertIn("beyond the region", text)
        self.assertIn("move the camera's region", text)
        self.assertEqual(self.check_config(), 0)


class PrimaryDisplay(SetupCase):
    daemon_config = {"slm": {"display": "DUMMY0"}}

    def test_is_named_and_replaced(self):
        answers = iter(["\n", "2", "q"]) if "DUMMY2" == self.first_offer() else iter(["\n", "\n", "q"])
        text = self.set_up("output", answer=lambda question: next(answers))
        self.assertIn("BAD: DUMMY0: ", text)
        self.assertIn("good: The camera's image changes with what DUMMY1 shows", text)

    def first_offer(self):
        outputs = self.call("slm.outputs")["outputs"]
        return next(output["name"] for output in outputs if output["usable"] and not output["selected"])


class NoLight(SetupCase):
    twin_config = {"light": {"peak_electrons": 1e-4}}

    def test_is_named_and_ends_the_commissioning(self):
        text = self.set_up("--yes", status=1)
        self.assertIn("BAD: The camera sees no light", text)
        self.assertIn("Switch on the laser", text)
        self.assertNotIn("Registration", text)
        self.call("slm.show", {"pattern": "flat"})
        exposure_us = self.call("camera.get")["settings"]["exposure_us"]
        self.set_up("--yes", "exposure", status=1)
        self.assertEqual(self.call("system.status")["slm"]["pattern"], "flat")
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], exposure_us)


class DarkPupil(SetupCase):
    def shade(self, *disc):
        keys = ("x_px", "y_px", "radius_px")
        self.twin.call("twin.set", {"shades": [dict(zip(keys, disc)) | {"transmission": 0.0}] if disc else []})

    def test_lost_spots_are_named_by_number_and_place(self):
        """First number 9 in the middle is dark, and then all but the lowest row, of a reference that has them."""
        self.places = self.call("reference.set", {"source": "model"})["positions_px"]
        self.shade(*CENTRE_PX, 0.52 * PITCH_PX)
        self.assert_named([9], "Lost spots are left out: ", self.set_up("--yes", "reference"))
        self.assert_named([9], "It lacks lost spots: ", self.set_up("--yes", "calibration"))
        self.shade()
        self.assertNotIn("ost spots", self.set_up("--yes", "reference"))
        self.shade(CENTRE_PX[0], CENTRE_PX[1] - 10 * PITCH_PX, 11.4 * PITCH_PX)
        text = self.set_up("--yes", "loop", status=1)
        self.assert_named(range(8), "no frame was valid, and these spots are lost: ", text)
        self.assertIn("px and 8 more", " ".join(text.split()))

    def assert_named(self, numbers, before, text):
        text = " ".join(text.split())
        self.assertIn(before, text)
        named = re.findall(r"(\d+) at \((\d+), (\d+)\) px", text[text.index(before):])
        self.assertEqual([int(number) for number, _, _ in named], list(numbers), text)
        for number, *place in named:
            for found, expected in zip(place, self.places[int(number)]):
                self.assertAlmostEqual(int(found), expected, delta=3.0)
        self.assertIn("Look there for a dark part of the beam", text)


class CameraGone(SetupCase):
    daemon_config = {"slm": {"settle_ms": 3000}}  # the step takes long enough to be interrupted

    def test_exposure_and_pattern_are_restored_when_it_is_back(self):
        before = self.call("camera.get")["settings"]
        command = self.ovws_command("setup", "--yes", "spot")
        step = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.addCleanup(step.communicate)
        wait_for(lambda: self.call("camera.get")["settings"]["exposure_us"] < before["exposure_us"]
                 and self.call("system.status")["state"] == "running", what="an exposure that the step has set")
        self.twin.call("twin.fault", {"kind": "unplug", "seconds": 15})
        self.assertEqual(step.wait(PROGRAM_PATIENCE_S), 1)
        wait_for(lambda: self.call("camera.get")["connected"], what="the camera")
        self.assertEqual(self.call("camera.get")["settings"], before)
        self.assertEqual(self.call("system.status")["slm"]["pattern"], "sensor")


if __name__ == "__main__":
    main()

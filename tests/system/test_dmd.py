"""A DMD in place of the SLM: binary holograms on the display, spots measured as an SLM's, and what a DMD refuses."""
import json
import subprocess
import unittest

from case import PROGRAM_PATIENCE_S, BenchCase, bench_module, main, merged, wait_for

DMD = {"modulator": "dmd"}
# The first order has (1 / pi)^2 of an SLM's light: a brighter laser.
TWIN = DMD | {"light": {"peak_electrons": 60000}}


class Dmd(BenchCase):
    twin_config = TWIN
    daemon_config = merged(DMD, {"slm": {"settle_ms": 0.0}, "state": {"directory": "state"}})

    def test_measures_known_modes_and_refuses_what_a_dmd_cannot(self):
        self.assertTrue(self.call("slm.verify")["equal"])
        self.take_reference(50)
        stream = self.stream("wavefront")
        known = {4: 0.1, 5: -0.08, 8: 0.05}
        self.twin.call("twin.set", {"aberration": [{"j": j, "waves": waves} for j, waves in known.items()], "norm": "rms"})
        self.modes_when(stream, lambda modes: all(abs(modes[j] - waves) < 0.05 * abs(waves) + 0.002 for j, waves in known.items()), "the hidden modes")
        # The hologram takes an aberration with the same sign as an SLM's.
        self.twin.call("twin.set", {"aberration": [], "norm": "rms"})
        self.call("aberration.set", {"modes": [{"j": 6, "waves": 0.1}]})
        self.modes_when(stream, lambda modes: abs(modes[6] - 0.1) < 0.007, "the introduced mode")
        self.assertTrue(self.call("slm.verify")["equal"])
        self.call("aberration.clear")
        with self.assertRaisesRegex(Exception, "two levels"):
            self.call("lut.run")
        with self.assertRaisesRegex(Exception, "order -3.*falls onto a spot"):
            self.call("sensor.set", {"grooves": [240, 0]})
        self.assertEqual(self.call("sensor.get")["grooves"], [200, 20])
        self.assertEqual(self.refused("aberration.sequence", {"patterns": [{"modes": []}]}).data["field"], "dmd.slots")
        self.frames_from_now(stream, 20)  # also after refused requests


class DmdBench(BenchCase):
    daemon_config = Dmd.daemon_config
    twin_config = merged(TWIN, {"slm": {"flatness_rms_waves": 0.08, "flatness_cycles": 2.0}})

    def test_the_flatness_is_measured_and_a_calibrated_loop_removes_an_aberration(self):
        self.run_job("registration.run", {})
        self.run_job("flatness.run", {})
        true = self.twin.call("twin.get", {"judge": "grating"})["flatness_modes"]
        measured = {mode["j"]: mode["waves"] for mode in self.call("flatness.get")["modes"]}
        error = sum((measured.get(j, 0.0) - true[j]) ** 2 for j in range(3, 15)) ** 0.5
        print(f"\n  flatness of {sum(waves ** 2 for waves in true[3:15]) ** 0.5:.4f} wave: error {error:.4f}")
        self.assertLess(error, 0.004)
        self.take_reference(50)
        self.run_job("calibration.run", {"frames": 10})
        self.twin.call("twin.set", {"aberration": [{"j": 4, "waves": 0.15}, {"j": 7, "waves": -0.06}], "norm": "rms"})
        self.close_loop(gain=0.3)

        def corrected():
            correction = {mode["j"]: mode["waves"] for mode in self.call("correction.get")["modes"]}
            return abs(correction.get(4, 0.0) - 0.15) < 0.004 and abs(correction.get(7, 0.0) + 0.06) < 0.004
        wait_for(corrected, what="the correction")


class BadConfiguration(unittest.TestCase):
    def refused(self, config):
        """Standard error of ovwsd with a configuration that it must refuse."""
        with bench_module.Bench() as bench:
            path = bench.directory / "bad.json"
            path.write_text(json.dumps(config))
            ended = subprocess.run([bench_module.find_programs() / "ovwsd", "--config", path], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertNotEqual(ended.returncode, 0)
        return ended.stderr

    def test_names_the_field_at_fault(self):
        for change, field in (({"dmd": {"amplitudes": [1.0, 0.5]}}, "dmd.amplitudes"),
                              ({"dmd": {"amplitudes": [0.0]}}, "dmd.amplitudes"),
                              ({"dmd": {"apodisation": 1.5}}, "dmd.apodisation"),
                              ({"dmd": {"slots": 1}}, "dmd.slots"),
                              ({"dmd": {"slots": 25}}, "dmd.slots"),
                              ({"dmd": {"bit_order": "GBR"}}, "dmd.bit_order"),
                              ({"modulator": "slm", "dmd": {"slots": 8}}, "dmd.slots"),
                              ({"slm": {"lut": "lut.csv"}}, "slm.lut"),
                              ({"slm": {"driver": "none"}}, "slm.driver"),
                              ({"sensor": {"grooves": [560, 0]}}, "sensor.grooves"),
                              ({"modulator": "dlp"}, "modulator")):
            self.assertIn(field, self.refused(DMD | change), msg=f"{change}")


if __name__ == "__main__":
    main()

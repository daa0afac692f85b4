"""sensor.advise: the daemon gives the advice of `ovws advise`, and its best sensor can be set."""
import json
import subprocess
import tempfile
from pathlib import Path

from case import PROGRAM_PATIENCE_S, BenchCase, main

LIGHT = {"modes": 18, "photo_electrons_per_s": 1e8, "longest_us": 2000}


class Advise(BenchCase):
    def test_the_advice_is_that_of_the_command_and_can_be_used(self):
        advice = self.run_job("sensor.advise", LIGHT)["result"]
        best = advice["best_first"][0]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        config = Path(folder.name) / "as_used.json"
        config.write_text(json.dumps(self.call("config.get")))
        offline = json.loads(subprocess.run([self.bench.programs / "ovws", "--json", "advise", "--modes", "18", "--photons", "1e8", "--frame-rate", "500",
                                             "--config", config], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, check=True).stdout)
        for key in ("subapertures_across", "charge", "exposure_us", "error_waves"):
            self.assertAlmostEqual(best[key], offline["best_first"][0][key], places=6, msg=key)
        self.assertEqual(len(advice["best_first"]) + len(advice["unfit"]), 18)
        self.assertGreater(advice["best_first"][-1]["error_waves"], best["error_waves"])
        self.call("sensor.set", {key: best[key] for key in ("subapertures_across", "charge", "grooves", "spacing")})
        self.assertEqual(self.call("sensor.get")["subapertures"], best["subapertures"])

    def test_it_can_be_stopped_and_bad_wishes_are_refused(self):
        job = self.call("sensor.advise", LIGHT | {"modes": 44})["job"]
        self.call("job.cancel", {"job": job})
        self.wait_until("running")
        for field, change in (("modes", {"modes": 2}), ("photo_electrons_per_s", {"photo_electrons_per_s": 0}), ("full_well_e", {"full_well_e": 1})):
            self.assertEqual(self.refused("sensor.advise", LIGHT | change).data["field"], field)


if __name__ == "__main__":
    main()

"""The user's locale has decimal commas, and SDL switches the daemon to it when it opens the output: no number changes.

Only the daemon sees the switch, which lasts, through an LD_PRELOAD library (stuck_locale.cpp).
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import unittest

from case import BenchCase, bench_module, main, wait_for

SETTINGS = {"rate_hz": 1.5, "electrons_per_dn": 2.75, "read_noise_e": 5.25, "black_level_dn": 3.5}
C_LOCALE = pathlib.Path("/usr/lib/locale/C.utf8")  # part of the C library's package


def make_comma_locale(folder):
    """Makes the locale `comma.utf8` in this folder for LOCPATH: C.UTF-8 with a comma for the decimal point."""
    shutil.copytree(C_LOCALE, folder / "comma.utf8")
    numeric = folder / "comma.utf8" / "LC_NUMERIC"
    numeric.write_bytes(numeric.read_bytes().replace(b".", b","))


class CommaLocale(BenchCase):
    small = True

    def start_daemon(self, **more):
        folder = self.bench.directory
        make_comma_locale(folder / "locales")
        self.locale = {"LC_ALL": "comma.utf8", "LOCPATH": str(folder / "locales")}
        self.seen = folder / "decimal-point"
        with self.preload("stuck_locale", OVWS_LOCALE_SEEN=str(self.seen), **self.locale):
            super().start_daemon(**more)

    def reloaded(self, **more):
        """Reloads the configuration with these keys; returns the event at the end."""
        path = self.bench.directory / "ovwsd.json"
        config = json.loads(path.read_text())
        config["slm"] |= more
        path.write_text(json.dumps(config))
        events = self.stream("event")
        self.bench.process("ovwsd").popen.send_signal(signal.SIGHUP)
        return wait_for(lambda: (event := events.next(0.5)) and event["kind"] == "config" and event, what="the reload's end")

    def test_is_not_that_of_the_daemon(self):
        # First that this test can fail: the locale exists, and has a comma.
        said = subprocess.run(["locale", "-k", "decimal_point"], env=os.environ | self.locale, capture_output=True, text=True, check=True)
        self.assertEqual(said.stdout, 'decimal_point=","\n')
        self.assertIn(wait_for(lambda: self.seen.exists() and self.seen.read_text(), what="the switch"), ",.")
        applied = self.call("refine.set", SETTINGS)["applied"]
        self.assertEqual({key: applied[key] for key in SETTINGS}, SETTINGS)
        flatness = self.bench.directory / "flatness.csv"
        flatness.write_text((",".join(["0.03586"] * 640) + "\n") * 384)
        event = self.reloaded(flatness=str(flatness), settle_ms=22.5)
        self.assertTrue(event["data"]["reloaded"], event)
        self.assertEqual(self.call("config.get")["slm"]["settle_ms"], 22.5)
        self.assertEqual(self.seen.read_text(), ".")


class Libraries(unittest.TestCase):
    def test_write_no_number_by_the_locale(self):
        """std::to_string of a floating-point number does, and looks like that of an integer. It alone calls __to_xstring."""
        libraries = sorted(bench_module.find_programs().parent.glob("**/libovws*.a"))
        self.assertGreater(len(libraries), 20)
        for library in libraries:
            symbols = subprocess.run(["nm", "--demangle", library], capture_output=True, text=True, check=True).stdout
            self.assertNotIn("__to_xstring", symbols, library)


if __name__ == "__main__":
    main()

"""Modes by index, orders and name, as dict, array and list; and jobs that are waited for."""
import contextlib
import io
import re
import unittest

import numpy as np
from paths import ROOT

from ovws_client import MODE_NAMES, Client, JobFailed, NoAnswer, methods, mode_index, mode_name, orders
from ovws_client.job import Job


class Sent(Client):
    """A client that notes what it would send."""

    def __init__(self, *replies):
        self.sent, self.replies = [], list(replies)

    def call(self, method, params=None):
        self.sent.append((method, params or {}))
        return self.replies.pop(0) if self.replies else {"job": 3}


class Modes(unittest.TestCase):
    def test_the_names_are_those_of_the_daemon(self):
        source = (ROOT / "core" / "optics" / "zernike.cpp").read_text()
        for j, name in enumerate(MODE_NAMES):
            self.assertIn(f'"{name}"', source)
            self.assertEqual((mode_name(j), mode_index(name), mode_index(name.upper().replace(" ", "_"))), (name, j, j))
        self.assertGreaterEqual(len(MODE_NAMES), 15)
        for j in range(200):
            self.assertEqual((mode_index(mode_name(j)), mode_index(orders(j)), mode_index(np.int64(j))), (j, j, j))

    def test_some_words_of_a_name_are_enough_if_they_are_of_one_mode(self):
        self.assertEqual([mode_index(words) for words in ("spherical", "horizontal-coma", "trefoil oblique", "secondary oblique")], [12, 8, 9, 11])
        for wrong, text in (("coma", r"vertical coma \(j = 7\), horizontal coma \(j = 8\)"), ("none", "piston"), ("", "piston"), (-1, "from 0 to 230"),
                            (231, "from 0 to 230"), (1.5, "integer"), ((2, 1), "not a mode")):
            with self.assertRaisesRegex(ValueError, text):
                mode_index(wrong)

    def test_a_method_takes_them_as_dict_array_and_list(self):
        wanted = [{"j": 1, "waves": 0.0}, {"j": 2, "waves": 0.0}, {"j": 3, "waves": 0.5}]
        for given in ([0.0, 0.0, 0.5], (0.0, 0.0, 0.5), np.array([0.0, 0.0, 0.5]), wanted, {1: 0.0, (1, 1): 0.0, "oblique astigmatism": 0.5}):
            client = Sent({})
            client.aberration_set(given, norm="unit")
            self.assertEqual(client.sent, [("aberration.set", {"modes": wanted, "norm": "unit"})])
        client = Sent({}, {}, {})
        client.correction_set([])
        client.loop_close(modes=["defocus", 3, (2, 2)], offsets={"defocus": 0.1})
        client.loop_close(modes=None)
        self.assertEqual([params for _, params in client.sent], [{"modes": []}, {"modes": [4, 3, 5], "offsets": [{"j": 4, "waves": 0.1}]}, {"modes": None}])
        wrong = Sent({})
        wrong.aberration_set([{"n": 2, "m": -2, "waves": 0.5}])  # as on the wire
        self.assertEqual(wrong.sent[0][1], {"modes": [{"n": 2, "m": -2, "waves": 0.5}]})

    def test_a_coefficient_is_found_by_name(self):
        from ovws_client.modes import coefficient
        j, waves = np.array([1, 2, 3, 4]), np.array([0.0, 0.0, np.nan, 0.25])
        self.assertEqual(coefficient(j, waves, "defocus"), 0.25)
        self.assertTrue(np.isnan(coefficient(j, waves, "oblique astigmatism")))
        with self.assertRaisesRegex(ValueError, r"not measured; the modes are j = \[1, 2, 3, 4\]"):
            coefficient(j, waves, "spherical")


def report(state, progress, error=None):
    return {"job": 3, "kind": "reference.take", "state": state, "progress": progress, "result": {"frames": 9} if state == "done" else None, "error": error}


class Jobs(unittest.TestCase):
    def test_a_method_that_starts_one_returns_it(self):
        client = Sent({"job": 3}, report("running", 0.5), report("done", 1.0))
        job = client.reference_take(frames=9)
        self.assertEqual((job, job["job"]), ({"job": 3}, 3))
        self.assertEqual(job.wait(), {"frames": 9})
        self.assertEqual(client.sent[1:], [("job.get", {"job": 3})] * 2)
        job.cancel()
        self.assertEqual(client.sent[-1], ("job.cancel", {"job": 3}))
        self.assertIsInstance(methods.Methods._job(client, {"job": 4}), Job)

    def test_progress_is_shown_on_standard_error(self):
        client = Sent(*[report("running", progress) for progress in (0.0, 0.5)], report("done", 1.0))
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            Job(client, {"job": 3}).wait(progress=True)
        lines = said.getvalue().strip().split("\r")
        self.assertRegex(lines[0], r"^reference\.take \[\.{30}\]   0 %")
        self.assertRegex(lines[1], r"^reference\.take \[#{15}\.{15}\]  50 % 0 s left")
        self.assertRegex(lines[2], r"^reference\.take \[#{30}\] 100 % done after 0 s")
        self.assertTrue(said.getvalue().endswith("\n"))

    def test_its_end_without_result_is_raised(self):
        with self.assertRaisesRegex(JobFailed, "it was cancelled"):
            Job(Sent(report("cancelled", 0.5)), {"job": 3}).wait()
        with self.assertRaisesRegex(NoAnswer, re.escape("job 3 (reference.take) has not ended within 0.0 s")):
            Job(Sent(*[report("running", 0.5)] * 9), {"job": 3}).wait(timeout_s=0.0)


if __name__ == "__main__":
    unittest.main()

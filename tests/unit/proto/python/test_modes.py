"""Modes by index, orders and name, as dict, array and list; and jobs that are waited for."""
import contextlib
import io
import re
import unittest
from unittest import mock

import numpy as np
from paths import ROOT

from ovws_client import MODE_NAMES, Client, JobFailed, NoAnswer, methods, mode_index, mode_name, orders
from ovws_client.job import Job


# Text and its mode, or None where it is refused: as mode_of of the command line.
CASES = {
    "7": 7, "0": 0, "230": 230, "007": 7, "231": None, "-1": None, "+7": None, "9999999999": None, "7.0": None, "٧": None, " 7": None,
    "3,-1": 7, "2,0": 4, "0,0": 0, "20,20": 230, "21,1": None, "3,+1": None, "3, -1": None, "2,1": None, "1,2,3": None, "3,": None, ",": None,
    "defocus": 4, "Defocus": 4, "vertical-coma": 7, "Coma_Vertical": 7, "COMA vertical": 7, "coma--vertical ": 7, "coma\tvertical": None,
    "oblique astigmatism": 3, "astigmatism oblique": 3, "astigmatism-oblique": 3, "astigmatism": None, "secondary astigmatism": None,
    "secondary oblique": 11, "secondary vertical": 13, "secondary": None, "vertical secondary astigmatism": 13, "quadrafoil oblique": 10,
    "spherical": 12, "primary": 12, "trefoil oblique": 9, "horizontal-coma": 8, "horizontal": None, "oblique": None, "coma": None, "tilt": None,
    "comma": None, "defocuss": None, "defocus defocus": 4, "defocus coma": None, "x": None, "": None, "-": None, " ": None, "_": None,
}


class Sent(Client):
    """A client that notes what it would send."""

    def __init__(self, *replies):
        self.sent, self.replies = [], list(replies)

    def call(self, method, params=None):
        self.sent.append((method, params or {}))
        reply = self.replies.pop(0) if self.replies else {"job": 3}
        if isinstance(reply, Exception):
            raise reply
        return reply


class Modes(unittest.TestCase):
    def test_the_names_are_those_of_the_daemon(self):
        source = (ROOT / "core" / "optics" / "zernike.cpp").read_text()
        for j, name in enumerate(MODE_NAMES):
            self.assertIn(f'"{name}"', source)
            self.assertEqual((mode_name(j), mode_index(name), mode_index(name.upper().replace(" ", "_"))), (name, j, j))
        self.assertGreaterEqual(len(MODE_NAMES), 15)
        for j in range(231):
            self.assertEqual((mode_index(mode_name(j)), mode_index(orders(j)), mode_index(np.int64(j))), (j, j, j))

    def test_the_rules_are_those_of_the_command_line(self):
        for text, j in CASES.items():
            with self.subTest(text=text):
                if j is not None:
                    self.assertEqual(mode_index(text), j)
                    continue
                with self.assertRaises(ValueError):
                    mode_index(text)

    def test_the_cases_hold_those_of_its_own_test(self):
        source = (ROOT / "tests" / "unit" / "text" / "mode_names_test.cpp").read_text()
        (refused,) = re.findall(r"const char\* text : \{(.*?)\}", source, re.DOTALL)
        ambiguous = re.findall(r'mode_of\("([^"]*)"\)\.error', source)
        theirs = {text: int(j) for text, j in re.findall(r'mode_of\("([^"]*)"\)\.value\(\), (\d+)\)', source)}
        theirs |= dict.fromkeys([*re.findall(r'"([^"]*)"', refused), *ambiguous])
        self.assertGreater(len(theirs), 15)
        self.assertEqual(theirs, {text: CASES.get(text, "missing") for text in theirs})

    def test_what_is_wrong_is_said(self):
        for wrong, text in (("coma", r"one of vertical coma \(j = 7\), horizontal coma \(j = 8\);"), ("none", "piston"), ("", "piston"), (-1, "from 0 to 230"),
                            ("astigmatism", r"one of oblique astigmatism \(j = 3\), vertical astigmatism \(j = 5\);"),
                            (231, "from 0 to 230"), ("231", "from 0 to 230"), (1.5, "integer"), ((2, 1), "not a mode"), ((21, 1), "from 0 to 230")):
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
        with contextlib.redirect_stderr(said), mock.patch("time.monotonic", return_value=0.0):
            Job(client, {"job": 3}).wait(progress=True)
        lines = said.getvalue().strip().split("\r")
        self.assertRegex(lines[0], r"^reference\.take \[\.{30}\]   0 %")
        self.assertRegex(lines[1], r"^reference\.take \[#{15}\.{15}\]  50 % 0 s left")
        self.assertRegex(lines[2], r"^reference\.take \[#{30}\] 100 % done after 0 s")
        self.assertTrue(said.getvalue().endswith("\n"))

    def test_a_lost_answer_is_asked_for_again(self):
        lost = NoAnswer("no answer")
        client = Sent(lost, report("running", 0.5), lost, lost, report("done", 1.0))
        self.assertEqual(Job(client, {"job": 3}).wait(), {"frames": 9})
        self.assertEqual(client.sent, [("job.get", {"job": 3})] * 5)
        with self.assertRaisesRegex(NoAnswer, "^no answer$"):
            Job(Sent(*[lost] * 99), {"job": 3}).wait(timeout_s=0.1)

    def test_its_end_without_result_is_raised(self):
        with self.assertRaisesRegex(JobFailed, "it was cancelled"):
            Job(Sent(report("cancelled", 0.5)), {"job": 3}).wait()
        with self.assertRaisesRegex(NoAnswer, re.escape("job 3 (reference.take) has not ended within 0.0 s")):
            Job(Sent(*[report("running", 0.5)] * 9), {"job": 3}).wait(timeout_s=0.0)


if __name__ == "__main__":
    unittest.main()

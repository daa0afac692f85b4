"""Every skipped case is listed with its reason, and every failed one with its error."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from xml.sax.saxutils import quoteattr, escape

REPORT = Path(__file__).resolve().parents[1] / "support" / "report_cases.py"
PYTHON_CASES = '''
import unittest
class Cases(unittest.TestCase):
    @unittest.skip("no engine")
    def test_decorated(self): pass
    def test_documented(self):
        """Has a line of its own in the output."""
        self.skipTest("the reader's file is missing")
    def test_same_reason(self): self.skipTest("no engine")
    def test_passes(self): pass
@unittest.skip("no p4p")
class Whole(unittest.TestCase):
    def test_a(self): pass
class SetUp(unittest.TestCase):
    @classmethod
    def setUpClass(cls): raise unittest.SkipTest("no display")
    def test_b(self): pass
unittest.main(verbosity=2)
'''
FAILING_CASES = '''
import unittest
def wait_for(what):
    raise TimeoutError(f"{what} did not come true")
class Cases(unittest.TestCase):
    def test_a(self): self.assertLess(3, 2, "too many")
    def test_b(self):
        for part in range(2):
            with self.subTest(part): wait_for(f"part {part}")
    def test_c(self): raise KeyError
unittest.main()
'''
GTEST_FAILURES = """/tests/camera_test.cpp:5: Failure
Failed in SetUpTestSuite
[ RUN      ] Camera.IsFound
../camera_test.cpp:12: Failure
Expected equality of these values:
  found
    Which is: 0
[  FAILED  ] Camera.IsFound (3 ms)
[ RUN      ] Camera.IsOpened
[       OK ] Camera.IsOpened (0 ms)
[ RUN      ] All/Camera.IsRead/0
camera_test.cpp:20: Failure
Value of: read
[  FAILED  ] All/Camera.IsRead/0, where GetParam() = 4 (0 ms)
[ RUN      ] Camera.Crashes
camera_test.cpp:30: Failure
Value of: alive
"""
NOISY_CASES = '''
import sys, unittest
class Cases(unittest.TestCase):
    def test_a(self):
        print("a line of its own", file=sys.stderr)
        self.skipTest("no engine")
    def test_b(self):
        for part in range(2):
            with self.subTest(part):
                self.skipTest("no part")
unittest.main()
'''
GTEST_OUTPUT = """[ RUN      ] Usb/Camera.IsUnplugged/0
camera_test.cpp:12: Skipped
No USB bus,
or no rights.

what TearDown says
[  SKIPPED ] Usb/Camera.IsUnplugged/0 (0 ms)
[ RUN      ] Camera.IsFound
[       OK ] Camera.IsFound (3 ms)
[  SKIPPED ] Slow.IsFast
[  SKIPPED ] 2 tests, listed below:
[  SKIPPED ] Usb/Camera.IsUnplugged/0
[  SKIPPED ] Slow.IsFast

  YOU HAVE 1 DISABLED TEST
"""


def report_of(status="run", reason=None, **outputs):
    """What is said of programs with these outputs, which ctest says failed for this reason; of one without output, that it did not run."""
    failure = f"<failure message={quoteattr(reason)}/>" if reason else ""
    cases = [f"<testcase name={quoteattr(name)} status='{status if output else 'notrun'}'>"
             f"{failure}<system-out>{escape(output)}</system-out></testcase>" for name, output in outputs.items()]
    with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
        file.write(f"<testsuite>{''.join(cases)}</testsuite>")
        file.flush()
        return subprocess.run([REPORT, file.name], capture_output=True, text=True, check=True).stdout.splitlines()


class ReportCases(unittest.TestCase):
    def test_cases_of_python_are_listed_by_reason(self):
        output = subprocess.run([sys.executable, "-c", PYTHON_CASES], stderr=subprocess.PIPE, text=True, check=True).stderr
        self.assertEqual(report_of(cases=output), ["skipped: 5 test cases", "  cases: 1: no display", "  cases: 2: no engine",
                                                   "  cases: 1: no p4p", "  cases: 1: the reader's file is missing"])

    def test_cases_whose_lines_cannot_be_read_are_counted(self):
        output = subprocess.run([sys.executable, "-c", NOISY_CASES], stderr=subprocess.PIPE, text=True, check=True).stderr
        self.assertEqual(report_of(cases=output), ["skipped: 3 test cases", "  cases: 3: see its output"])

    def test_cases_of_googletest_are_listed(self):
        self.assertEqual(report_of(camera=GTEST_OUTPUT), ["skipped: 3 test cases", "  camera: 1: No USB bus, or no rights.", "  camera: 1: disabled", "  camera: 1: see its output"])

    def test_a_program_that_did_not_run_is_listed(self):
        self.assertEqual(report_of(absent="", present="OK"), ["skipped: 1 test cases", "  absent: 1: see its output"])
        self.assertEqual(report_of("notrun", format="checks\nanother version\n"), ["skipped: 1 test cases", "  format: 1: another version"])

    def test_nothing_skipped_is_said(self):
        self.assertEqual(report_of(present="OK"), ["skipped: no test cases"])

    def test_errors_of_python_are_listed(self):
        output = subprocess.run([sys.executable, "-c", FAILING_CASES], stderr=subprocess.PIPE, text=True).stderr
        self.assertEqual(report_of("fail", cases=output), [
            "skipped: no test cases", "failed:", "  cases: test_b (<string>:9): TimeoutError: part 0 did not come true",
            "  cases: test_b (<string>:9): TimeoutError: part 1 did not come true", "  cases: test_c (<string>:10): KeyError",
            "  cases: test_a (<string>:6): AssertionError: 3 not less than 2 : too many"])
        self.assertEqual(report_of(cases=output), ["skipped: no test cases"], "another run of it passed")

    def test_errors_of_googletest_are_listed(self):
        killed = "[ RUN      ] Camera.IsFound\n[       OK ] Camera.IsFound (0 ms)\n[ RUN      ] Camera.IsOpened\nopening\n"
        self.assertEqual(report_of("fail", "Timeout", camera=GTEST_FAILURES, killed=killed, unread="nothing"), [
            "skipped: no test cases", "failed:", "  camera: outside a case (camera_test.cpp:5): Failed in SetUpTestSuite",
            "  camera: Camera.IsFound (camera_test.cpp:12): Expected equality of these values: found",
            "  camera: All/Camera.IsRead/0 (camera_test.cpp:20): Value of: read", "  camera: Camera.Crashes (camera_test.cpp:30): Value of: alive",
            "  killed: Camera.IsOpened: Timeout: see its output", "  unread: Timeout: see its output"])


if __name__ == "__main__":
    unittest.main(verbosity=2)

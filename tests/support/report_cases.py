#!/usr/bin/python3
"""Prints from the JUnit file of a ctest run which test cases were skipped and why, and the errors of those that failed.

    tests/support/report_cases.py FILE

The programs' own totals decide how many: a case whose line cannot be read is listed without its name.
"""
import re
import sys
import xml.etree.ElementTree as ElementTree

UNITTEST = re.compile(r"^(?!setUpClass)(\w+) \([^)]*\)(?:\n.*)? \.\.\. skipped ([\"'])(.*)\2$", re.MULTILINE)
UNITTEST_CLASS = re.compile(r"^setUpClass \(([^)]*)\) \.\.\. skipped ([\"'])(.*)\2$", re.MULTILINE)
UNITTEST_TOTAL = re.compile(r"^(?:OK|FAILED) \(.*\bskipped=(\d+)", re.MULTILINE)
GTEST = re.compile(r"^\[  SKIPPED \] ([\w./]+)$", re.MULTILINE)  # in the list at the end
GTEST_TOTAL = re.compile(r"^\[  SKIPPED \] (\d+) tests?, listed below", re.MULTILINE)
GTEST_DISABLED = re.compile(r"^ +YOU HAVE (\d+) DISABLED TESTS?", re.MULTILINE)
UNITTEST_FAILED = re.compile(r"^(?:FAIL|ERROR): (\S+) .*?\n(.*?)(?=^={70}$|^Ran \d+ tests? in )", re.MULTILINE | re.DOTALL)
TRACEBACK_PLACE = re.compile(r'^  File "(?:.*/)?([^"/]+)", line (\d+)', re.MULTILINE)
TRACEBACK_ERROR = re.compile(r"^([A-Za-z_][\w.]*(?:: .*)?)$", re.MULTILINE)
GTEST_CASES = re.compile(r"^\[ RUN      \] (\S+)$|^\[  (?:     OK|FAILED |SKIPPED) \] .*\)$", re.MULTILINE)  # begin and end of each
GTEST_ERROR = re.compile(r"^(?:.*/)?([^/\s]+):(\d+): Failure\n(.*(?:\n +.*)?)", re.MULTILINE)
MOST_ERRORS, MOST_LETTERS = 5, 300  # of one program, of one error
UNKNOWN = "see its output"


def gtest_reason(case, output):
    """What the case said of its skip."""
    own = re.search(rf"^\[ RUN      \] {re.escape(case)}$(.*?)^\[  SKIPPED \] {re.escape(case)} \(", output, re.MULTILINE | re.DOTALL)
    said = re.search(r": Skipped\n(.*?)(?:\n\n|\Z)", own[1] if own else "", re.DOTALL)
    return " ".join(said[1].split()) if said and said[1].strip() else UNKNOWN


def skipped_cases(output):
    """(test case, reason) of each skipped case in the output of one test program."""
    cases = [match.group(1, 3) for pattern in (UNITTEST, UNITTEST_CLASS) for match in pattern.finditer(output)]
    cases += [(case, gtest_reason(case, output)) for case in GTEST.findall(output)]
    cases += [(f"disabled {number}", "disabled") for count in GTEST_DISABLED.findall(output) for number in range(int(count))]
    known = list(dict.fromkeys(cases))
    total = sum(int(count) for pattern in (UNITTEST_TOTAL, GTEST_TOTAL, GTEST_DISABLED) for count in pattern.findall(output))
    return known + [(f"unnamed {number}", UNKNOWN) for number in range(total - len(known))]


def unittest_error(said):
    """(file, line, text) of a traceback: where the test stood, and the error."""
    last = said.rpartition("Traceback (most recent call last):\n")[2]
    place, errors = TRACEBACK_PLACE.search(last), TRACEBACK_ERROR.findall(last)
    return (*place.groups(), errors[0]) if place and errors else None


def gtest_errors(output):
    """(test case, (file, line, text)) of each failure, also of a case that did not end, and of one outside the cases."""
    parts = GTEST_CASES.split("\n" + output)  # what was said, the name of the case that begins or None, what was said, ...
    cases, texts = [None, *parts[1::2]], parts[::2]
    found = [(case or "outside a case", error) for case, said in zip(cases, texts) for error in GTEST_ERROR.findall(said)]
    return found + ([(cases[-1], None)] if cases[-1] and not GTEST_ERROR.search(texts[-1]) else [])  # killed without a word


def errors(output, reason):
    """What the cases of one test program failed of, with file and line; without any, ctest's reason."""
    found = [(case, unittest_error(said)) for case, said in UNITTEST_FAILED.findall(output)]
    found += gtest_errors(output)
    lines = [f"{case} ({error[0]}:{error[1]}): {' '.join(error[2].split())[:MOST_LETTERS]}" if error else f"{case}: {reason or 'failed'}: {UNKNOWN}" for case, error in found]
    return list(dict.fromkeys(lines))[:MOST_ERRORS] or [f"{reason or 'failed'}: {UNKNOWN}"]


def main():
    found, failed = {}, []
    for test in ElementTree.parse(sys.argv[1]).iter("testcase"):
        output = test.findtext("system-out") or ""
        if test.get("status") == "fail":
            failed += [f"  {test.get('name')}: {error}" for error in errors(output, getattr(test.find("failure"), "attrib", {}).get("message"))]
        last = (output.strip() or UNKNOWN).splitlines()[-1]
        for case, reason in skipped_cases(output) or ([("all", last)] if test.get("status") == "notrun" else []):
            found.setdefault((test.get("name"), reason), []).append(case)
    print(f"skipped: {sum(map(len, found.values())) or 'no'} test cases")
    for (test, reason), cases in sorted(found.items()):
        print(f"  {test}: {len(cases)}: {reason}")
    if failed:
        print("failed:", *failed, sep="\n")


if __name__ == "__main__":
    main()

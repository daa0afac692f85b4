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
PYTHON_ERROR = re.compile(r'^  File "(?:.*/)?([^"/]+)", line (\d+), in \S+\n(?:    .*\n)*([A-Za-z_][\w.]*(?:: .*)?)$', re.MULTILINE)
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


def errors(output):
    """What the cases of one test program failed of, with file and line."""
    found = [f"{file}:{line}: {' '.join(said.split())[:MOST_LETTERS]}" for pattern in (PYTHON_ERROR, GTEST_ERROR) for file, line, said in pattern.findall(output)]
    return list(dict.fromkeys(found))[:MOST_ERRORS] or [UNKNOWN]


def main():
    found, failed = {}, []
    for test in ElementTree.parse(sys.argv[1]).iter("testcase"):
        output = test.findtext("system-out") or ""
        if test.get("status") == "fail":
            failed += [f"  {test.get('name')}: {error}" for error in errors(output)]
        for case, reason in skipped_cases(output) or ([("all", UNKNOWN)] if test.get("status") == "notrun" else []):
            found.setdefault((test.get("name"), reason), []).append(case)
    print(f"skipped: {sum(map(len, found.values())) or 'no'} test cases")
    for (test, reason), cases in sorted(found.items()):
        print(f"  {test}: {len(cases)}: {reason}")
    if failed:
        print("failed:", *failed, sep="\n")


if __name__ == "__main__":
    main()

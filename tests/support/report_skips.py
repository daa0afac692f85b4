#!/usr/bin/python3
"""Prints which test cases were skipped and why, from the JUnit file of a ctest run.

    tests/support/report_skips.py FILE
"""
import re
import sys
import xml.etree.ElementTree as ElementTree

UNITTEST = re.compile(r"^(?!setUpClass)(\w+) \([^)]*\)(?:\n.*)? \.\.\. skipped ([\"'])(.*)\2$", re.MULTILINE)
UNITTEST_CLASS = re.compile(r"^setUpClass \(([^)]*)\) \.\.\. skipped ([\"'])(.*)\2$", re.MULTILINE)
GTEST = re.compile(r": Skipped\n(.*)\n*\[  SKIPPED \] ([\w./]+) \(")


def skipped_cases(output):
    """(test case, reason) of each skipped case in the output of one test program."""
    cases = [match.group(1, 3) for pattern in (UNITTEST, UNITTEST_CLASS) for match in pattern.finditer(output)]
    cases += [match.groups()[::-1] for match in GTEST.finditer(output)]
    return list(dict.fromkeys(cases))


def main():
    found = {}
    for test in ElementTree.parse(sys.argv[1]).iter("testcase"):
        output = test.findtext("system-out") or ""
        for case, reason in skipped_cases(output) or ([("all", "see its output")] if test.get("status") == "notrun" else []):
            found.setdefault((test.get("name"), reason), []).append(case)
    print(f"skipped: {sum(map(len, found.values())) or 'no'} test cases")
    for (test, reason), cases in sorted(found.items()):
        print(f"  {test}: {len(cases)}: {reason}")


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Checks that no part of the tree grows beyond its budget: lines of code (blank lines and comments included), words of Markdown, files.

    tests/lint/sizes.py [root] [--table]      prints what exceeds its budget, or the whole table

A commit that raises a budget says why. A part that has become much smaller than its budget fails too: lower the budget, so that it stays small.
"""
import subprocess
import sys
from pathlib import Path

ROOT = Path(next((a for a in sys.argv[1:] if not a.startswith("-")), Path(__file__).parents[2])).resolve()
SLACK = 0.03  # how far a part may be below its budget
CODE = (".hpp", ".cpp")
TEST_CODE = (*CODE, ".py", ".mjs")

# Part: budget, suffixes, the paths that it has (the longest prefix of a file decides).
BUDGETS = {
    "core": (21630, CODE, ["core/"]),
    "proto, config": (7850, CODE, ["proto/", "config/"]),
    "drivers": (6550, CODE, ["drivers/"]),
    "twin": (7550, CODE, ["drivers/twin/"]),
    "ovwsd": (24400, CODE, ["daemon/ovwsd/"]),
    "examine": (6450, CODE, ["daemon/examine/"]),
    "ovws": (15600, CODE, ["daemon/ovws/"]),
    "web, shared": (4810, CODE, ["daemon/web/", "daemon/shared/"]),
    "tests": (57730, TEST_CODE, ["tests/"]),
}
MOST_WORDS = 41800  # of Markdown
MOST_FILES = 900  # of production code


def tracked():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    return [name for name in listed.stdout.decode().split("\0") if name and (ROOT / name).is_file()]


def part_of(name):
    """The part whose path is the longest prefix of this file, if its suffix counts."""
    found = max(((path, part) for part, (_, _, paths) in BUDGETS.items() for path in paths if name.startswith(path)), default=None, key=lambda one: len(one[0]))
    return found[1] if found and name.endswith(BUDGETS[found[1]][1]) else None


def measured():
    sizes, words, files = dict.fromkeys(BUDGETS, 0), 0, 0
    for name in tracked():
        text = (ROOT / name).read_text(errors="replace")
        part = part_of(name)
        if part:
            sizes[part] += text.count("\n")
            files += part != "tests"
        if name.endswith(".md"):
            words += len(text.split())
    rows = [(part, sizes[part], BUDGETS[part][0]) for part in BUDGETS]
    return [*rows, ("words of Markdown", words, MOST_WORDS), ("files of production code", files, MOST_FILES)]


def main():
    rows, wrong = measured(), []
    for part, size, budget in rows:
        if "--table" in sys.argv:
            print(f"{part:26} {size:7} of {budget:7}")
        if size > budget:
            wrong.append(f"{part}: {size} is more than its budget of {budget}: find what is said twice")
        elif size < (1.0 - SLACK) * budget:
            wrong.append(f"{part}: {size} is far below its budget of {budget}: lower the budget in {Path(__file__).name}")
    print("\n".join(wrong) or f"{len(rows)} sizes checked, none is beyond its budget")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""The rules of the tree that a compiler does not hold: one-way includes, where vendors' headers may be, sizes, words.

    tests/lint/check.py [root]      prints each violation as file:line: rule, and exits 1 if there is any
"""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve()

# Each room may include itself and the rooms named here: dependencies point one way.
MAY_INCLUDE = {
    "core": set(),
    "proto": {"core"},
    "config": {"core", "proto"},
    "drivers": {"core", "proto"},
    "daemon": {"core", "proto", "config", "drivers"},
}
# Vendors' headers, and the only places that may know them.
VENDORS = {
    r"arv\.h|aravis": ("drivers/aravis/", "drivers/twin/"),
    r"SDL": ("drivers/sdl/",),
    r"X11/": ("drivers/sdl/", "drivers/twin/"),
    r"zmq": ("drivers/zmq/", "drivers/twin/"),
    r"nlohmann/": ("proto/", "config/", "daemon/", "drivers/twin/"),
    r"opencv2/": ("daemon/",),
    r"systemd/": ("daemon/",),
    r"CLI/": ("daemon/", "drivers/twin/"),
    r"spdlog/": ("daemon/", "drivers/twin/"),
}
# Threads are made in one place a program.
THREAD_OWNERS = ("daemon/thread_plan.", "daemon/study/parallel.", "drivers/twin/")
MOST_LINES = 500
MOST_FUNCTION_LINES = 60


def tracked(*patterns):
    listed = subprocess.run(["git", "ls-files", "-z", *patterns], cwd=ROOT, capture_output=True, check=True)
    return [name for name in listed.stdout.decode().split("\0") if name]


def room_of(name):
    return name.split("/")[0]


def check_include(name, included):
    room, other = room_of(name), room_of(included)
    if other in MAY_INCLUDE and other != room and other not in MAY_INCLUDE[room]:
        yield f"{room} must not include {included}"
    if room == "drivers" and other == "drivers" and included.split("/")[1] != name.split("/")[1]:
        yield f"drivers never see each other: {included}"
    for vendor, homes in VENDORS.items():
        if re.match(vendor, included) and not name.startswith(homes):
            yield f"{included} belongs to {' and '.join(homes)}"


def check_code_line(name, line):
    include = re.match(r'\s*#\s*include\s*[<"]([^>"]+)[>"]', line)
    if include:
        yield from check_include(name, include[1])
    if re.search(r"\bstd::j?thread\b|pthread_create|std::async", line) and not name.startswith(THREAD_OWNERS):
        if "this_thread" not in line and "#include" not in line:
            yield "threads are made only in " + " and ".join(THREAD_OWNERS)
    if re.search(r"\b(TODO|FIXME|XXX|HACK)\b", line):
        yield "finish it, or file it"


def check_text_line(line):
    if re.search(r"(^|[^A-Za-z0-9_.])/(home|work|root)/", line):
        yield "a path of one machine"


def functions_too_long(lines):
    """Yields (line, length) of brace-delimited bodies that begin at column 0: functions, in this code's format."""
    start = None
    for number, line in enumerate(lines, 1):
        if re.match(r"[A-Za-z].*[)\w>]\s*(const)?\s*(noexcept)?\s*\{$", line) and not re.match(r"(namespace|class|struct|enum|union)\b", line):
            start = number
        elif line.startswith("}") and start:
            if number - start + 1 > MOST_FUNCTION_LINES:
                yield start, number - start + 1
            start = None


def main():
    found = []
    code = [n for n in tracked("*.hpp", "*.cpp") if room_of(n) in MAY_INCLUDE]
    for name in code:
        lines = (ROOT / name).read_text().splitlines()
        for number, line in enumerate(lines, 1):
            found += [f"{name}:{number}: {rule}" for rule in check_code_line(name, line)]
        found += [f"{name}:{n}: a function of {length} lines" for n, length in functions_too_long(lines)]
    for name in tracked():
        path = ROOT / name
        if path.suffix in {".png", ".tif", ".bin"} or path.is_symlink() or not path.is_file():
            continue
        lines = path.read_text(errors="replace").splitlines()
        if path.suffix in {".hpp", ".cpp", ".py"} and len(lines) > MOST_LINES:
            found.append(f"{name}:1: {len(lines)} lines, at most {MOST_LINES}")
        if name.startswith("tests/lint/"):
            continue
        for number, line in enumerate(lines, 1):
            found += [f"{name}:{number}: {rule}" for rule in check_text_line(line)]
    print("\n".join(found) or f"{len(code)} source files keep the rules")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""Checks rules of the tree that the compiler does not: one-way includes, places of vendor headers, sizes, forbidden words, width of Markdown,
and names of Python that are not defined or not used.

    tests/lint/check.py [root]      prints each violation as file:line: rule, and exits 1 if there is any
"""
import ast
import re
import subprocess
import sys
from pathlib import Path

from pyflakes.checker import Checker

ROOT = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve()

# Top-level folders ("rooms"): each may include itself and the rooms listed here.
MAY_INCLUDE = {
    "core": set(),
    "proto": {"core"},
    "config": {"core", "proto"},
    "drivers": {"core", "proto"},
    "daemon": {"core", "proto", "config", "drivers"},
}
# Vendor headers, and the only places that may include them.
VENDORS = {
    r"arv\.h|aravis": ("drivers/aravis/", "drivers/twin/"),
    r"SDL": ("drivers/sdl/",),
    r"X11/": ("drivers/sdl/", "drivers/twin/"),
    r"zmq": ("drivers/zmq/",),
    r"hdf5\.h": ("drivers/hdf5/",),
    r"libdeflate": ("drivers/record/", "drivers/replay/"),
    r"nlohmann/": ("proto/", "config/", "daemon/", "drivers/twin/"),
    r"opencv2/|tiffio": ("daemon/ovws/cli/",),
    r"png\.h": ("drivers/png/",),
    r"systemd/": ("daemon/",),
    r"CLI/": ("daemon/", "drivers/twin/"),
    r"spdlog/": ("daemon/", "drivers/twin/"),
    r"prometheus/|Civet|civet": ("daemon/ovws/metrics/",),
    r"n?curses": ("daemon/ovws/screen/",),
    r"boost/": ("daemon/web/",),
}
USERS_OF_DRIVER = {"hdf5": ("record", "replay"), "zmq": ("twin",)}  # drivers that other drivers use
# Each program creates threads in one place only.
THREAD_OWNERS = ("daemon/examine/commission/commissioning.", "daemon/ovwsd/threads/thread_plan.", "daemon/examine/machine/display.", "daemon/ovws/study/parallel.", "daemon/web/feeds.", "drivers/twin/")
# The locale decides what these read or write; core/base/number_text.hpp does without. A library may switch it: see core/port/c_locale.cpp.
BY_LOCALE = r"\bstd::sto(d|f|ld)\b|\b(strto(d|f|ld)|atof|[sf]?scanf|v?sn?printf|ostringstream|setlocale|uselocale)\b|std::locale|printf\(.*%[-+ #0-9.*lL]*[aefgAEFG]"
LOCALE_OWNERS = ("core/port/c_locale.cpp", "daemon/ovws/screen/terminal.cpp", "daemon/ovws/cli/image_codecs.cpp")
CODE = ("*.hpp", "*.cpp", "*.inc")
MOST_LINES = 500
MOST_FUNCTION_LINES = 60
MOST_COLUMNS = 100  # of Markdown; clang-format checks the code's


def tracked(*patterns):
    listed = subprocess.run(["git", "ls-files", "-z", *patterns], cwd=ROOT, capture_output=True, check=True)
    return [name for name in listed.stdout.decode().split("\0") if name]


def room_of(name):
    return name.split("/")[0]


def read_targets():
    """{folder: {target: [linked targets]}} from all CMakeLists.txt files."""
    folders = {}
    for name in tracked("*CMakeLists.txt"):
        text = re.sub(r"#[^\n]*", "", (ROOT / name).read_text())
        for target, arguments in re.findall(r"\bovws_(?:module|program)\(\s*(?:NAME\s+)?([\w-]+)([^)]*)\)", text):
            links = re.sub(r"\b(SOURCES|PRECOMPILED|PRECOMPILED_BY)\b.*?(?=\b(?:PUBLIC|PRIVATE|SOURCES|PRECOMPILED\w*)\b|$)", "", arguments, flags=re.S)
            folders.setdefault(str(Path(name).parent), {})[target] = [w for w in links.split() if w not in ("PUBLIC", "PRIVATE")]
    return folders


TARGETS = read_targets()
LINKS = {target: links for targets in TARGETS.values() for target, links in targets.items()}


def targets_of(name):
    """The targets of the nearest folder above a file that declares targets."""
    for folder in Path(name).parents:
        if str(folder) in TARGETS:
            return TARGETS[str(folder)]
    return {}


def usable(target, seen):
    """Adds all targets that a target links, directly or indirectly, to `seen` and returns it."""
    for linked in LINKS.get(target, ()):
        if linked not in seen:
            seen.add(linked)
            usable(linked, seen)
    return seen


def check_include(name, included):
    room, other = room_of(name), room_of(included)
    if other in MAY_INCLUDE and other != room and other not in MAY_INCLUDE[room]:
        yield f"{room} must not include {included}"
    own, others = targets_of(name), targets_of(included)
    if other in MAY_INCLUDE and not any(others.keys() & usable(target, {target}) for target in own):
        yield f"{included} belongs to a target that {' or '.join(own)} does not link"
    if room == "drivers" and other == "drivers":
        user, used = name.split("/")[1], included.split("/")[1]
        if user != used and user not in USERS_OF_DRIVER.get(used, ()):
            yield f"a driver must not include another driver: {included}"
    for vendor, homes in VENDORS.items():
        if re.match(vendor, included) and not name.startswith(homes):
            yield f"{included} may be included only in {' and '.join(homes)}"


def check_code_line(name, line):
    include = re.match(r'\s*#\s*include\s*[<"]([^>"]+)[>"]', line)
    if include:
        yield from check_include(name, include[1])
    if re.search(r"\bstd::j?thread\b|pthread_create|std::async", line) and not name.startswith(THREAD_OWNERS):
        if "this_thread" not in line and "#include" not in line:
            yield "threads may be created only in " + " and ".join(THREAD_OWNERS)
    if name not in LOCALE_OWNERS and re.search(BY_LOCALE, line.split("//")[0]):
        yield "depends on the locale: use core/base/number_text.hpp or fmt"
    if re.search(r"\b(TODO|FIXME|XXX|HACK)\b", line):
        yield "unfinished work: finish it, or file an issue"


def check_text_line(line):
    if re.search(r"(^|[^A-Za-z0-9_.])/(home|work|root)/", line):
        yield "path of a specific machine"


def blanked(text):
    """The code with comments, literals and preprocessor lines blanked out; line numbers are kept."""
    pattern = r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Za-z_])\'(?:\\.|[^\'\\\n])\'|^[ \t]*#(?:\\\n|[^\n])*'
    return re.sub(pattern, lambda found: re.sub(r"[^\n]", " ", found[0]), text, flags=re.S | re.M)


def opens_function(statement):
    """Whether a brace after this text begins a function body. None: it initialises a member in a constructor's initialiser list."""
    if "(" not in statement or re.search(r"=\s*$", statement):
        return False
    if re.search(r"\)[\w\s]*:(?!:)", statement) and re.search(r"\w\s*$", statement):
        return None
    return True


def functions_too_long(text):
    """Yields (line, length) of functions that are too long, counted from the signature; lambdas belong to their function."""
    kinds = []  # kinds of the open braces
    begin, function_begin = 0, None  # start of the current statement and of the current function
    text = blanked(text)
    for found in re.finditer(r"[{};]", text):
        at = found.start()
        inside = function_begin is not None
        if found[0] == "{":
            kind = "block" if inside else opens_function(text[begin:at])
            kinds.append(kind)
            if kind is True:
                function_begin = begin + len(text[begin:at]) - len(text[begin:at].lstrip())
            if kind is not None:
                begin = at + 1
            continue
        kind = kinds.pop() if found[0] == "}" and kinds else "end"
        if kind is True:
            first, last = (text.count("\n", 0, where) + 1 for where in (function_begin, at))
            if last - first + 1 > MOST_FUNCTION_LINES:
                yield first, last - first + 1
            function_begin = None
        if kind is not None:
            begin = at + 1


def misplaced_methods(name, text, homes):
    """The methods `prefix.verb` of the control socket stand in one file of daemon/ovwsd/control; their constants are kPrefixVerb."""
    for constant in re.findall(r"\brow<k(\w+)", text):
        prefix = re.match(r"[A-Z][a-z]+", constant)[0].lower()
        if homes.setdefault(prefix, name) != name:
            yield f"method k{constant} belongs to {homes[prefix]}, as all of {prefix}.*"


def too_wide(lines):
    """Numbers of the Markdown lines over 100 columns that could wrap: outside code, tables and links to images."""
    in_code = False
    for number, line in enumerate(lines, 1):
        in_code ^= line.lstrip().startswith("```")
        if not in_code and len(line) > MOST_COLUMNS and not line.startswith(("|", "    ", "![", "```")):
            yield number


def wrong_names(name, lines):
    """What pyflakes finds in a Python program, but on lines whose noqa is for names (F): (line, text)."""
    for message in Checker(ast.parse("\n".join(lines)), name).messages:
        if "# noqa: F" not in lines[message.lineno - 1]:
            yield message.lineno, message.message % message.message_args


def main():
    found, homes = [], {}
    code = [n for n in tracked(*CODE) if room_of(n) in MAY_INCLUDE]
    for name in code:
        text = (ROOT / name).read_text()
        for number, line in enumerate(text.splitlines(), 1):
            found += [f"{name}:{number}: {rule}" for rule in check_code_line(name, line)]
        if name.startswith("daemon/ovwsd/control/"):
            found += [f"{name}:1: {rule}" for rule in misplaced_methods(name, text, homes)]
        found += [f"{name}:{n}: function of {length} lines, at most {MOST_FUNCTION_LINES}" for n, length in functions_too_long(text)]
    for name in tracked():
        path = ROOT / name
        if path.suffix in {".png", ".tif", ".bin"} or path.is_symlink() or not path.is_file():
            continue
        lines = path.read_text(errors="replace").splitlines()
        if path.suffix in {".hpp", ".cpp", ".inc", ".py", ".js", ".css"} and len(lines) > MOST_LINES:
            found.append(f"{name}:1: {len(lines)} lines, at most {MOST_LINES}")
        if path.suffix == ".py" or (lines and re.match(r"#!.*\bpython3?$", lines[0])):
            found += [f"{name}:{number}: {rule}" for number, rule in wrong_names(name, lines)]
        if name.startswith("tests/lint/"):
            continue
        for number, line in enumerate(lines, 1):
            found += [f"{name}:{number}: {rule}" for rule in check_text_line(line)]
        if path.suffix == ".md":
            found += [f"{name}:{number}: over {MOST_COLUMNS} columns" for number in too_wide(lines)]
    print("\n".join(found) or f"{len(code)} source files checked, no violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

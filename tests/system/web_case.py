"""A bench with its live page, and a headless browser."""
import atexit
import fcntl
import http.client
import json
import os
import pathlib
import subprocess
import time

from case import PATIENCE_S, PROGRAM_PATIENCE_S, BenchCase, main, merged, wait_for

HOST, PORT = "127.0.0.1", 7704
ADDRESS = f"{HOST}:{PORT}"
PAGE_RATE = {"camera": {"frame_rate_hz": 30.0}}  # more than a page shows is only work
PACKAGES = ("playwright-core@1.65.1", "axe-core@4.10.2")


class Refused(Exception):
    """An HTTP response other than 200."""


class WebCase(BenchCase):
    web_arguments = ("--control",)

    def start(self):
        super().start()
        self.start_web()

    def start_daemon(self, **more):
        super().start_daemon(**merged(PAGE_RATE, merged(self.daemon_config, more)))

    def start_web(self, *more):
        """Starts ovws-web and reads its links by name."""
        self.web = self.bench.start("ovws-web", [self.bench.programs / "ovws-web", *self.web_arguments, *more])
        self.web.wait_for_line("ready")
        lines = (self.bench.directory / "ovws-web.out").read_text().splitlines()
        self.links = dict(line.split() for line in lines)
        self.tokens = {name: link.partition("#")[2] for name, link in self.links.items()}

    def ask(self, method, path, body=None, token=None, host=ADDRESS, headers=None):
        """(status, headers, bytes) of one request, sent without corrections by the HTTP library."""
        connection = http.client.HTTPConnection(HOST, PORT, timeout=PATIENCE_S)
        self.addCleanup(connection.close)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        all_headers = {"Host": host} | ({"Authorization": f"Bearer {token}"} if token else {}) | (headers or {})
        if body is not None and "Content-Length" not in all_headers:
            all_headers["Content-Length"] = str(len(body))
        for name, value in all_headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        if body is not None:
            connection.send(body)
        reply = connection.getresponse()
        return reply.status, reply.headers, reply.read()

    def command(self, method, params=None, right="control"):
        """Sends a command like the page; returns the daemon's reply."""
        status, _, body = self.ask("POST", "/rpc", json.dumps({"method": method, "params": params or {}}).encode(), self.tokens[right])
        if status != 200:
            raise Refused(status)
        return json.loads(body)

    def messages(self, token=None):
        """Yields the stream's messages: (JSON, binary)."""
        connection = http.client.HTTPConnection(HOST, PORT, timeout=PATIENCE_S)
        self.addCleanup(connection.close)
        connection.request("GET", "/stream", headers={"Authorization": f"Bearer {token or self.tokens['look']}"})
        reply = connection.getresponse()
        if reply.status != 200:
            raise Refused(reply.status)
        while head := reply.read(8):
            sizes = int.from_bytes(head[:4], "little"), int.from_bytes(head[4:], "little")
            yield json.loads(reply.read(sizes[0])), reply.read(sizes[1])

    def message(self, schema, condition=lambda message: True):
        """The first message with this schema that fulfils the condition; it must come within PROGRAM_PATIENCE_S."""
        end = time.monotonic() + PROGRAM_PATIENCE_S
        return next((m, b) for m, b in self.messages() if m["schema"] == schema and condition(m) or self.assertLess(time.monotonic(), end, schema))

    def health(self, condition=lambda message: True):
        return self.message("ovws.web.health/1", condition)[0]


class Browser:
    """A page of headless Chromium, driven by Playwright. All tests of a script share one Chromium."""

    process = None
    opened = 0

    def __init__(self, packages):
        if not Browser.process:
            script = pathlib.Path(__file__).with_name("browser.mjs")
            Browser.process = subprocess.Popen(["node", script, packages], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            atexit.register(Browser.end)
        Browser.opened += 1
        self.page = Browser.opened

    def ask(self, what, **given):
        self.process.stdin.write(json.dumps({"what": what, "page": self.page, **given}) + "\n")
        self.process.stdin.flush()
        answer = json.loads(self.process.stdout.readline())
        if "error" in answer:
            raise AssertionError(f"{what}: {answer['error']}")
        return answer["result"]

    def open(self, url):
        self.ask("open", url=url)

    def run(self, body, *values):
        """Runs a function with this body and these arguments in the page; returns its result."""
        return self.ask("run", body=body, values=values)

    def resize(self, width, height):
        self.ask("resize", width=width, height=height)

    def press(self, key):
        self.ask("press", key=key)

    def click(self, selector):
        self.ask("click", selector=selector)

    def fill(self, selector, text):
        self.ask("fill", selector=selector, text=text)

    def mouse(self, *steps):
        """Moves and presses the mouse: ("move", x, y), ("down",), ("up",), ("wheel", dx, dy)."""
        self.ask("mouse", steps=steps)

    def drag(self, start, end):
        self.mouse(("move", *start), ("down",), ("move", (start[0] + end[0]) / 2, (start[1] + end[1]) / 2), ("move", *end), ("up",))

    def pinch(self, at, before, after):
        """Two fingers whose distance changes, CSS pixels."""
        fingers = [[[at[0] - distance / 2, at[1]], [at[0] + distance / 2, at[1]]] for distance in (before, (before + after) / 2, after)]
        self.ask("touch", steps=[["touchStart", fingers[0][:1]], ["touchStart", fingers[0]], *[["touchMove", both] for both in fingers[1:]], ["touchEnd", []]])

    def box(self, selector):
        """(left, top, width, height) of the element in the window, CSS pixels."""
        return self.run("const b = document.querySelector(arguments[0]).getBoundingClientRect(); return [b.left, b.top, b.width, b.height]", selector)

    def choose(self, selector, value):
        self.ask("choose", selector=selector, value=value)

    def download(self, selector):
        """Clicks; returns the name and the bytes of the file that this saves."""
        file = self.ask("download", selector=selector)
        return file["name"], pathlib.Path(file["path"]).read_bytes()

    def text(self, selector):
        return self.run("return document.querySelector(arguments[0]).textContent", selector)

    def wait_text(self, selector, condition, timeout_s=PATIENCE_S):
        """Waits until the element's text fulfils the condition; returns the text."""
        return wait_for(lambda: (text := self.text(selector)) is not None and condition(text) and text, timeout_s, selector)

    def close(self):
        self.ask("close")

    @staticmethod
    def end():
        Browser.process.stdin.close()
        Browser.process.wait(PROGRAM_PATIENCE_S)
        Browser.process.stdout.close()


class BrowserCase(WebCase):
    """A bench whose live page is looked at; skipped without Playwright. Its script ends with browser_main()."""

    packages = None  # the folder with Playwright

    def setUp(self):
        if not self.packages:
            self.skipTest("no Playwright: npm and a network are needed once")
        super().setUp()

    def new_browser(self, height=900):
        browser = Browser(self.packages)
        self.addCleanup(browser.close)
        browser.resize(1440, height)
        return browser

    def check_console(self):
        """Checks that the console has no warnings or errors of the page. Scripts of these tests have no address; a busy browser's stream may
        have ended, because it read too slowly, and the page has begun another."""
        self.assertEqual([line for line in self.browser.ask("said") if ADDRESS in line and f"{ADDRESS}/stream: Failed to load" not in line], [])

    def load_axe(self):
        self.browser.run((self.packages / "node_modules" / "axe-core" / "axe.min.js").read_text())

    def check_axe(self, *looks, parts=None):
        """Checks that nothing keeps anybody out, in each look (theme, width), of the page or of these parts of it."""
        self.load_axe()
        for theme, width in looks:
            self.browser.run("document.documentElement.dataset.theme = arguments[0]", theme)
            self.browser.resize(width, 900)
            wait_for(lambda width=width: self.browser.run("return innerWidth") == width)
            found = self.browser.run("return (await axe.run(arguments[0] ?? document)).violations", parts)
            grave = [(v["id"], v["impact"], v["nodes"][0]["html"]) for v in found if v["impact"] in ("serious", "critical")]
            self.assertEqual(grave, [], f"{theme}, {width} px")
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)


def browser_main():
    BrowserCase.packages = browser_packages()  # before the network namespace removes the network
    main()


def browser_packages():
    """The folder with Playwright and axe-core from npm, cached beside the build; none without npm or network."""
    folder = pathlib.Path(os.environ["OVWS_BUILD"]) / "browser"
    folder.mkdir(exist_ok=True)
    with open(folder / "lock", "w") as lock:  # several tests may start at once
        fcntl.flock(lock, fcntl.LOCK_EX)
        if all((folder / "node_modules" / package.split("@")[0]).exists() for package in PACKAGES):
            return folder
        try:
            subprocess.run(["npm", "install", "--prefix", folder, "--ignore-scripts", "--no-audit", "--no-fund", *PACKAGES], check=True, capture_output=True, timeout=PROGRAM_PATIENCE_S)
        except (OSError, subprocess.SubprocessError):
            return None
    return folder

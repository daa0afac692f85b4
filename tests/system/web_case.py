"""A bench with its live page, and a browser without a window that looks at it."""
import http.client
import json

from case import BenchCase, wait_for

HOST, PORT = "127.0.0.1", 7704
ADDRESS = f"{HOST}:{PORT}"


class Refused(Exception):
    """An HTTP answer that is no success."""


class WebCase(BenchCase):
    web_arguments = ("--control",)

    def start(self):
        super().start()
        self.start_web()

    def start_web(self, *more):
        """ovws-web, and its links by name."""
        self.web = self.bench.start("ovws-web", [self.bench.programs / "ovws-web", *self.web_arguments, *more])
        self.web.wait_for_line("ready", 10.0)
        lines = (self.bench.directory / "ovws-web.out").read_text().splitlines()
        self.links = dict(line.split() for line in lines)
        self.tokens = {name: link.partition("#")[2] for name, link in self.links.items()}

    def ask(self, method, path, body=None, token=None, host=ADDRESS, headers=None):
        """(status, headers, bytes) of one request, as it is: nothing is put right on the way."""
        connection = http.client.HTTPConnection(HOST, PORT, timeout=10)
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
        """The daemon's answer to a command of the page."""
        status, _, body = self.ask("POST", "/rpc", json.dumps({"method": method, "params": params or {}}).encode(), self.tokens[right])
        if status != 200:
            raise Refused(status)
        return json.loads(body)

    def messages(self, token=None):
        """The stream's messages, as they come: (JSON, binary)."""
        connection = http.client.HTTPConnection(HOST, PORT, timeout=10)
        self.addCleanup(connection.close)
        connection.request("GET", "/stream", headers={"Authorization": f"Bearer {token or self.tokens['look']}"})
        reply = connection.getresponse()
        if reply.status != 200:
            raise Refused(reply.status)
        while head := reply.read(8):
            sizes = int.from_bytes(head[:4], "little"), int.from_bytes(head[4:], "little")
            yield json.loads(reply.read(sizes[0])), reply.read(sizes[1])

    def message(self, schema, condition=lambda message: True):
        """The first message of that kind that fulfils the condition."""
        return next((m, b) for m, b in self.messages() if m["schema"] == schema and condition(m))

    def health(self, condition=lambda message: True):
        return self.message("ovws.web.health/1", condition)[0]


def open_browser(case, width=1440, height=1000, link="control", dark=False):
    """A Chromium of this test's own, with the page of that link. Its X server is none: it is headless."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    profile = case.bench.directory / "chromium"
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={profile}",
                     f"--window-size={width},{height}", "--disable-background-networking", "--no-first-run"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    case.addCleanup(driver.quit)
    resize(driver, width, height)
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
    driver.get(case.links[link])
    return driver


def resize(driver, width, height):
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})


def text_of(driver, selector):
    return driver.execute_script("return document.querySelector(arguments[0]).textContent", selector)


def wait_text(driver, selector, condition, timeout_s=30.0):
    """The text of the element once it fulfils the condition."""
    return wait_for(lambda: (text := text_of(driver, selector)) is not None and condition(text) and text, timeout_s, selector)

"""The page Commission in a real browser: Enter alone repairs a bench with faults; what is left is judged by the twin's truth."""
import json
import time

from case import PROGRAM_PATIENCE_S, wait_for
from test_setup import FAULTS, MOST_WAVES, TOO_LONG, SetupCase
from web_case import BrowserCase, browser_main

WHERE = """const b = document.getElementById("primary");
    return {title: document.getElementById("title").textContent, primary: b.hidden ? "" : b.textContent,
            can: b.getAttribute("aria-disabled") !== "true", busy: !document.getElementById("cancel").hidden,
            verdict: document.getElementById("verdict").hidden ? "" : document.querySelector("#verdict p").textContent, states: [...document.querySelectorAll("#steps button")].map((s) => s.dataset.state)}"""


class CommissionCase(BrowserCase, SetupCase):
    def setUp(self):
        super().setUp()
        self.browser = self.new_browser()
        self.open("control")

    def open(self, link):
        self.browser.open("about:blank")
        self.browser.open(self.links[link].replace("/#", "/commission.html#"))
        self.browser.wait_text("#title", lambda text: text[0].isdigit())
        self.idle()

    def idle(self):
        """Waits until nothing runs; returns what the page shows."""
        return wait_for(lambda: not (shown := self.browser.run(WHERE))["busy"] and shown, PROGRAM_PATIENCE_S, "the end of the step")

    def click_primary(self):
        """Clicks the large button, and waits for what follows."""
        return self.act(lambda: self.browser.click("#primary"))

    def begin(self, action):
        """Does what starts something, and waits until the page shows that it runs, or what it has changed."""
        before = self.browser.run(WHERE)
        action()
        wait_for(lambda: self.browser.run(WHERE) != before, what=f"a change after {before}")

    def act(self, action):
        """Does what starts something, and waits for what follows; returns what the page shows then."""
        self.begin(action)
        return self.idle()

    def click_until(self, title):
        """Clicks the large button until the step of this title has a verdict; returns what the page shows."""
        for _ in range(12):
            shown = self.click_primary()
            if title in shown["title"] and shown["verdict"]:
                return shown
        self.fail(shown)


class Faults(CommissionCase):
    twin_config = FAULTS
    daemon_config = TOO_LONG

    def test_enter_alone_repairs_the_bench(self):
        reports, begun, shown = [], time.monotonic(), self.idle()
        while shown["primary"]:
            self.assertLess(len(reports), 4 * len(shown["states"]), reports)
            self.assertTrue(shown["can"], shown)
            reports.append((shown["title"], shown["primary"], shown["verdict"]))
            print(f"{time.monotonic() - begun:6.1f} s", *reports[-1], sep="  ", flush=True)
            shown = self.act(lambda: self.browser.press("Enter"))
        self.assertEqual(set(shown["states"]), {"done"}, reports)
        self.assertIn("commissioned", self.browser.text("#end-title"))
        self.assertFalse(self.browser.run("return document.getElementById('end').hidden"))
        left = self.twin.call("twin.get", {"judge": "sensor"})["wavefront"]["rms_waves"]
        print(f"true residual {left:.4f} wave", flush=True)
        self.assertLess(left, MOST_WAVES)
        self.check_console()


class NoLight(CommissionCase):
    twin_config = {"light": {"peak_electrons": 1e-4}}

    def test_is_named_with_what_to_do(self):
        shown = self.click_until("SLM output")
        self.assertIn("The camera sees no light", shown["verdict"])
        self.assertIn("Switch on the laser", self.browser.text("#advice"))
        self.assertEqual(shown["states"][2], "failed")


class PrimaryDisplay(CommissionCase):
    daemon_config = {"slm": {"display": "DUMMY0"}}

    def test_is_named_and_replaced_by_the_offer(self):
        shown = self.click_until("SLM output")
        self.assertIn("DUMMY0 is the primary output", shown["verdict"])
        self.assertIn("use output", shown["primary"])
        self.click_primary()
        wait_for(lambda: self.call("system.status")["slm"]["connected"], what="the other output")
        self.assertNotEqual(self.call("config.get")["slm"]["display"], "DUMMY0")


class Controls(CommissionCase):
    daemon_config = {"slm": {"display": "DUMMY2"}}

    def choose(self, title):
        self.browser.click(f"#steps button:has(.name:text-is('{title}'))")

    def test_a_wrong_output_is_reported_and_repaired_by_its_offer(self):
        self.choose("SLM output")
        shown = self.click_primary()
        self.assertIn("DUMMY2", shown["verdict"])
        self.assertIn("DUMMY1", shown["primary"])  # the offer
        shown = self.click_primary()
        self.assertIn("DUMMY1", shown["verdict"])
        self.assertEqual(shown["states"][2], "done", shown)
        self.assertEqual(self.call("config.get")["slm"]["display"], "DUMMY1")
        self.act(lambda: self.browser.click("#undo"))
        self.assertEqual(self.call("config.get")["slm"]["display"], "DUMMY2")
        self.check_keys_cancel_and_skip()
        self.check_what_a_view_only_link_shows()
        self.check_looks()
        self.check_console()

    def check_keys_cancel_and_skip(self):
        self.choose("Exposure")
        self.browser.run("document.getElementById('primary').focus()")
        self.begin(lambda: self.browser.press("Enter"))
        self.assertEqual(self.browser.run("return document.activeElement.id"), "primary")  # keeps the focus
        self.browser.run("document.getElementById('cancel').click()")
        shown = self.idle()
        self.assertIn(shown["states"][4], ("failed", "done"))  # it may have ended before
        self.choose("Look-up table")
        self.browser.click("#skip")
        wait_for(lambda: "skipped" in self.idle()["states"], what="a skipped step")

    def check_what_a_view_only_link_shows(self):
        self.open("look")
        self.browser.wait_text("#why", lambda text: "View only" in text)
        self.assertIn("skipped", self.browser.run(WHERE)["states"])
        self.choose("Settle time")
        self.assertFalse(self.browser.run(WHERE)["can"])
        self.browser.run("document.getElementById('primary').click()")  # does nothing
        self.assertIsNone(json.loads(self.ask("GET", "/commission", token=self.tokens["look"])[2])["running"])
        self.assertEqual(self.ask("POST", "/commission", b'{"action":"run","step":"settle"}', self.tokens["look"])[0], 403)
        self.assertEqual(self.ask("GET", "/commission")[0], 401)
        self.open("control")


    def check_looks(self):
        self.load_axe()
        for width, scheme in ((1440, "light"), (390, "light"), (1440, "dark"), (390, "dark")):
            self.browser.resize(width, 900)
            self.browser.ask("colours", scheme=scheme)
            found = self.browser.run("return (await axe.run()).violations")
            self.assertEqual([(v["id"], v["nodes"][0]["html"]) for v in found], [], (width, scheme))
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)


if __name__ == "__main__":
    browser_main()

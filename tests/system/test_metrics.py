"""ovws metrics: the exported metrics agree with the daemon's messages and with the dashboard."""
import http.client
import json
import math
import os
import re
import signal
import socket
import subprocess
import time

from case import PATIENCE_S, PROGRAM_PATIENCE_S, ROOT, BenchCase, main, next_message, wait_for
from prometheus_client.parser import text_string_to_metric_families

ADDRESS = ("127.0.0.1", 7705)
DASHBOARD = ROOT / "config" / "grafana" / "ovws.json"
UNITS = ("_seconds", "_hertz", "_decibels", "_waves", "_pixels", "_meters", "_ratio", "_info")
WORDS = ("sum", "rate", "increase", "exp", "histogram_quantile", "by", "le", "stage", "label_values", "instance")


def get(path="/metrics", **headers):
    connection = http.client.HTTPConnection(*ADDRESS, timeout=PATIENCE_S)
    try:
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.read().decode(), answer.getheader("Content-Type", "")
    finally:
        connection.close()


class Scrape:
    """One scrape, parsed strictly: every sample follows the HELP and TYPE lines of its family, which appear once."""

    def __init__(self):
        status, self.text, content_type = get()
        assert status == 200 and content_type.startswith("text/plain"), (status, content_type)
        lines = [line for line in self.text.splitlines() if " exposer_" not in line and not line.startswith("exposer_")]
        self.families = {family.name: family for family in text_string_to_metric_families("\n".join(lines) + "\n")}
        self.types = dict(re.findall(r"^# TYPE (\S+) (\S+)$", "\n".join(lines), re.MULTILINE))
        helps = re.findall(r"^# HELP (\S+) \S.*$", "\n".join(lines), re.MULTILINE)
        assert sorted(helps) == sorted(self.types) and len(set(helps)) == len(helps), "HELP and TYPE once for each"
        samples = [line.split(" ")[0] for line in lines if line and not line.startswith("#")]
        assert len(set(samples)) == len(samples), "no sample twice"
        assert self.text.endswith("\n")

    def samples(self):
        return [sample for family in self.families.values() for sample in family.samples]

    def value(self, name, **labels):
        found = [s.value for s in self.samples() if s.name == name and labels.items() <= s.labels.items()]
        return found[0] if len(found) == 1 else None


def names_in(expression):
    """The metrics used by a query."""
    bare = re.sub(r'"[^"]*"', "", expression)
    bare = re.sub(r"\{[^}]*\}|\[[^\]]*\]|\bby \([^)]*\)", "", bare)
    return {word for word in re.findall(r"[a-zA-Z_]\w*", bare) if word not in WORDS}


class Metrics(BenchCase):
    def serve(self, *arguments):
        process = subprocess.Popen([self.bench.programs / "ovws", "metrics", *arguments], stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.assertEqual(process.stdout.readline(), "metrics at http://127.0.0.1:7705/metrics\n")
        return process

    def refused_command(self, *arguments):
        done = subprocess.run([self.bench.programs / "ovws", "metrics", *arguments], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(done.returncode, 1, done.stdout)
        return done.stderr

    def scrape_when(self, condition, what):
        return wait_for(lambda: condition(scrape := Scrape()) and scrape, what=what)

    def test_they_say_what_the_daemon_says(self):
        self.take_reference(30)
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.25}]})
        self.call("camera.set", {"exposure_us": 1500, "gain_db": 2})
        statuses = self.stream("status")
        self.serve()
        scrape = self.scrape_when(lambda s: s.value("ovws_wavefront_valid") == 1 and abs(s.value("ovws_wavefront_rms_waves") - 0.25) < 0.01
                                  and s.value("ovws_frames_published_total") > 300,
                                  "a valid wavefront of 0.25 wave after 300 frames")
        status = self.call("system.status")
        for name in status["counters"]:
            self.assertEqual(scrape.types[f"ovws_{name}_total"], "counter", name)
            self.assertLessEqual(scrape.value(f"ovws_{name}_total"), self.call("system.status")["counters"][name])
        self.assertGreater(scrape.value("ovws_frames_published_total"), 30)
        self.assertEqual(scrape.value("ovws_state", state="running"), 1)
        self.assertEqual(sum(s.value for s in scrape.samples() if s.name == "ovws_state"), 1)
        self.assertEqual(scrape.value("ovws_reference", state="stale"), 1)
        self.assertAlmostEqual(scrape.value("ovws_camera_exposure_seconds"), 0.0015)
        self.assertEqual(scrape.value("ovws_camera_gain_decibels"), 2)
        self.assertEqual(scrape.value("ovws_spots_tracked"), status["sensor"]["subapertures"])
        self.assertEqual(scrape.value("ovws_spots_missing"), 0)
        self.assertAlmostEqual(scrape.value("ovws_wavefront_coefficient_waves", j="3"), 0.25, delta=0.01)
        self.assertEqual(len(scrape.families["ovws_wavefront_coefficient_waves"].samples), status["sensor"]["modes"])
        self.assertEqual(scrape.value("ovws_build_info", ovws=status["versions"]["ovws"]), 1)
        self.check_names(scrape)
        self.check_latencies(scrape, statuses)
        self.check_dashboard(scrape)

    def check_names(self, scrape):
        for name, kind in scrape.types.items():
            self.assertRegex(name, r"^ovws_[a-z][a-z0-9_]*$")
            self.assertEqual(name.endswith("_total"), kind == "counter", name)
            self.assertNotRegex(name, r"_(us|ms|ns|milliseconds|microseconds|db|px|hz)\b")
        exposed = {name for name in scrape.types if name.endswith(UNITS)}
        self.assertLessEqual({"ovws_frame_latency_seconds", "ovws_uptime_seconds", "ovws_camera_frame_rate_hertz"}, exposed)
        self.assertFalse([s for s in scrape.samples() if math.isnan(s.value)], "what is not known is left out")

    def check_latencies(self, scrape, statuses):
        """Compares with the status message that was scraped."""
        family = scrape.families["ovws_frame_latency_seconds"]
        self.assertEqual(family.type, "histogram")
        uptime_s = scrape.value("ovws_uptime_seconds")
        status = wait_for(lambda: (s := next_message(statuses)) and abs(s["uptime_s"] - uptime_s) < 1e-4 and s, what="the status of the scrape")
        for stage in ("tracked", "reconstructed", "published"):
            buckets = [(float(s.labels["le"]), s.value) for s in family.samples if s.name.endswith("_bucket") and s.labels["stage"] == stage]
            count = scrape.value("ovws_frame_latency_seconds_count", stage=stage)
            total = scrape.value("ovws_frame_latency_seconds_sum", stage=stage)
            self.assertEqual(buckets, sorted(buckets), "edges and counts rise")
            self.assertEqual(buckets[-1], (math.inf, count))
            said = status["latency"][stage]["since_start"]
            self.assertEqual((count, [n for _, n in buckets[:-1]]), (said["count"], said["below"]))
            self.assertAlmostEqual(total, 1e-6 * said["sum_us"])
            low = sum(le_below * n for (le_below, n) in zip([0.0] + [le for le, _ in buckets], differences(buckets)))
            self.assertLess(low, total)
        # Latencies are counted once a second, and the frames all the time.
        wait_for(lambda: abs((s := next_message(statuses))["latency"]["published"]["since_start"]["count"] - s["counters"]["frames_published"]) <= 3,
                 what="a latency of each published frame")

    def check_dashboard(self, scrape):
        dashboard = json.loads(DASHBOARD.read_text())
        queries = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
        queries += [v["query"]["query"] for v in dashboard["templating"]["list"] if isinstance(v["query"], dict)]
        self.assertGreater(len(queries), 20)
        known = {sample.name for sample in scrape.samples()}
        for query in queries:
            names = names_in(query)
            self.assertTrue(names, query)
            self.assertLessEqual(names, known, query)
        self.assertTrue(all(panel["gridPos"]["x"] + panel["gridPos"]["w"] <= 24 for panel in dashboard["panels"]))

    def test_a_daemon_that_goes_and_comes(self):
        first = self.serve()
        self.scrape_when(lambda s: s.value("ovws_up") == 1, "a daemon that answers")
        os.kill(self.bench.process("ovwsd").pid, signal.SIGKILL)
        gone = self.scrape_when(lambda s: s.value("ovws_up") == 0, "its end")
        self.assertEqual(set(gone.types), {"ovws_up"}, "nothing old looks new")
        self.bench.stop("ovwsd")
        first.send_signal(signal.SIGTERM)
        self.assertEqual(first.wait(PROGRAM_PATIENCE_S), 0)
        self.serve()  # a new exporter, which has never seen a daemon
        self.assertEqual(Scrape().value("ovws_up"), 0)
        begin = time.monotonic()
        self.start_daemon()
        self.wait_until("running")
        new = self.scrape_when(lambda s: s.value("ovws_up") == 1, "the new one")
        self.assertLess(new.value("ovws_uptime_seconds"), time.monotonic() - begin)
        self.assertIsNone(Scrape().value("ovws_wavefront_rms_waves"), "no reference, no RMS")

    def test_addresses_and_hostile_readers(self):
        for address in ("0.0.0.0:7705", "*:7705", "192.0.2.1:7705", "[::]:7705"):
            self.assertIn("other machines could read", self.refused_command("--listen", address))
        for address in ("7705", "127.0.0.1", "127.0.0.1:0", "127.0.0.1:77050", "localhost:7705"):
            self.assertIn("is not ADDRESS:PORT", self.refused_command("--listen", address))
        process = self.serve()
        self.assertIn("in use by another program?", self.refused_command())
        self.assertEqual(get("/")[0], 404)
        for host in ("localhost:9000", "127.0.0.1", "[::1]:7705"):
            self.assertEqual(get(Host=host)[0], 200, host)
        for host in ("rebound.example.org:7705", "127.0.0.1.example.org", ""):
            status, text, _ = get(Host=host)
            self.assertEqual((status, "ovws_up" in text), (403, False), host)
        self.assertEqual(get("/../../etc/passwd")[0], 404)
        for sent in (b"\0" * 4096, b"GET " + b"/x" * 100000, b"GET /metrics HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n"):
            with socket.create_connection(ADDRESS, timeout=PATIENCE_S) as hostile:
                try:
                    hostile.sendall(sent)
                    hostile.recv(100)
                except OSError:
                    pass
        silent = [socket.create_connection(ADDRESS, timeout=PATIENCE_S) for _ in range(20)]
        self.addCleanup(lambda: [one.close() for one in silent])
        self.scrape_when(lambda s: s.value("ovws_up") == 1, "an answer in spite of them")
        self.assertIsNone(process.poll())


def differences(buckets):
    counts = [count for _, count in buckets]
    return [after - before for before, after in zip([0.0] + counts, counts)]


if __name__ == "__main__":
    main()

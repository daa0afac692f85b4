"""ovws-web without a browser: access control, age of its data, slow readers, and restarts of the daemon."""
import http.client
import itertools
import json
import os
import select
import signal
import socket
import subprocess
import zlib
from io import BytesIO
from pathlib import Path

import numpy
from PIL import Image

from case import PATIENCE_S, PROGRAM_PATIENCE_S, main, next_message, wait_for
from web_case import ADDRESS, HOST, PORT, Refused, WebCase

CURRENT = 10  # frames of the 30 a second


ESTABLISHED, CLOSE_WAIT = "01", "08"


def unread(state):
    """Unread bytes of each connection of ovws-web in this TCP state; CLOSE_WAIT: closed by the browser."""
    rows = [row.split() for row in Path("/proc/net/tcp").read_text(encoding="ascii").splitlines()[1:]]
    return [int(row[4].partition(":")[2], 16) for row in rows if row[1].endswith(f":{PORT:04X}") and row[3] == state]


class Web(WebCase):
    def wavefronts(self, count):
        """The next wavefront messages of a new stream."""
        return [next(m for m, _ in stream if m["schema"] == "ovws.wavefront/1") for stream in [self.messages()] for _ in range(count)]

    def check_current(self, count):
        """Checks that a browser's messages are those of now: one of the last half of `count` is at most CURRENT frames older than the
        daemon's newest. A single stall is the machine's; messages that queue up make all of them old but the first."""
        frames, stream, behind = self.stream("wavefront"), self.messages(), []
        newest = next_message(frames)["seq"]
        for _ in range(count):
            found = next(message for message, _ in stream if message["schema"] == "ovws.wavefront/1")
            while (message := frames.next(0.0)) is not None:
                newest = message["seq"]
            behind.append(newest - found["seq"])
        late = sorted(behind[count // 2:])
        print(f"\n  a browser's messages are {late[len(late) // 2]} frames old at the median, at least {late[0]}")
        self.assertLessEqual(late[0], CURRENT)

    def test_what_is_refused_is_counted_and_logged(self):
        look, control = self.tokens["look"], self.tokens["control"]
        body = json.dumps({"method": "camera.set", "params": {"gain_db": 1}}).encode()
        attempts = [  # refusal, HTTP status, request
            ("origin", 403, dict(method="POST", path="/rpc", body=body, token=control, headers={"Origin": "http://evil.example"})),
            ("origin", 403, dict(method="GET", path="/stream", token=look, headers={"Sec-Fetch-Site": "cross-site"})),
            ("token", 401, dict(method="POST", path="/rpc", body=body)),
            ("token", 401, dict(method="GET", path="/stream", token=look[:-1])),
            ("right", 403, dict(method="POST", path="/rpc", body=body, token=look)),
            ("command", 403, dict(method="POST", path="/rpc", body=b'{"method": "focus.run"}', token=control)),
            ("path", 404, dict(method="GET", path="/../../etc/passwd", token=look)),
            ("path", 404, dict(method="GET", path="/page/%2e%2e/main.cpp")),
            ("method", 405, dict(method="DELETE", path="/", token=control)),
            ("host", 421, dict(method="GET", path="/", host="evil.example:7704")),
            ("host", 421, dict(method="POST", path="/rpc", body=body, token=control, host="rebound.example")),
            ("size", 413, dict(method="POST", path="/rpc", token=control, headers={"Content-Length": str(10 << 20)})),
            ("size", 413, dict(method="POST", path="/rpc", token=control, headers={"Transfer-Encoding": "chunked"})),
            ("malformed", 400, dict(method="POST", path="/rpc", body=b"[" * 60000, token=control)),
        ]
        wanted = {}
        for kind, status, request in attempts:
            with self.subTest(request=str(request)[:120]):
                got, headers, text = self.ask(**request)
                self.assertEqual((got, json.loads(text)["refused"]), (status, kind))
                self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
            wanted[kind] = wanted.get(kind, 0) + 1
        self.assertEqual(self.call("camera.get")["settings"]["gain_db"], 0.0)
        counted = self.health(lambda m: sum(m["refused"].values()) == len(attempts))["refused"]
        self.assertEqual({kind: count for kind, count in counted.items() if count}, wanted)
        for kind in wanted:
            self.assertIn(f"refused ({kind})", self.bench.log("ovws-web"))
        self.assertNotIn(control, self.bench.log("ovws-web"))

    def test_noise_and_greed_end_nothing(self):
        for noise in (b"\x00\xff" * 5000, b"GET / HTTP/1.1\r\n" + b"x: y\r\n" * 100000, b"GET " + b"/" * 100000, b"\r\n" * 10):
            with socket.create_connection((HOST, PORT), timeout=PATIENCE_S) as raw:
                try:
                    raw.sendall(noise)
                    raw.shutdown(socket.SHUT_WR)
                    raw.recv(4096)
                except OSError:
                    pass  # the server closed the connection, as expected
        silent = [socket.create_connection((HOST, PORT)) for _ in range(70)]
        for connection in silent:
            connection.close()
        sent = 0
        with socket.create_connection((HOST, PORT), timeout=PATIENCE_S) as raw:  # sends a body of 10 MiB
            raw.sendall(b"POST /rpc HTTP/1.1\r\nHost: %s\r\nContent-Length: %d\r\n\r\n" % (ADDRESS.encode(), 10 << 20))
            try:
                while sent < 10 << 20:
                    sent += raw.send(b"x" * 65536)
            except OSError:
                pass
        self.assertLess(sent, 10 << 20)
        wait_for(lambda: self.ask("GET", "/")[0] == 200, what="an answer after all that")
        self.assertTrue(self.web.alive())

    def test_silent_connections_keep_nobody_out(self):
        stream = self.messages()
        next(stream)
        silent = [socket.create_connection((HOST, PORT)) for _ in range(200)]
        for connection in silent:
            self.addCleanup(connection.close)
        for path, token in (("/", None), ("/hologram.png", self.tokens["look"])) * 20:
            self.assertEqual(self.ask("GET", path, token=token)[0] // 100, 2)
            silent.append(socket.create_connection((HOST, PORT)))  # replace closed ones
            self.addCleanup(silent[-1].close)
            next(stream)
        self.health(lambda m: m["refused"]["full"] >= 137)  # one for each excess connection

    def test_connections_with_a_token_keep_their_places(self):
        self.hold_daemon()
        calls = [self.send_command("loop.get") for _ in range(64)]
        wait_for(lambda: unread(ESTABLISHED) == 64 * [0], what="64 requests read")
        with self.assertRaises(ConnectionError):
            self.ask("GET", "/")
        calls[-1].close()
        wait_for(lambda: len(unread(ESTABLISHED)) == 63 and not unread(CLOSE_WAIT), what="the end of the connection that was left")
        self.assertEqual(self.answered(calls[:-1]), [])
        self.assertEqual(self.ask("GET", "/")[0], 200)

    def test_numbers_are_those_of_the_stream_and_of_now(self):
        self.take_reference()
        frames, direct = self.stream("wavefront"), {}
        first = next_message(frames)["seq"]
        later = (message for message, _ in self.messages() if message["schema"] == "ovws.wavefront/1" and message["seq"] > first)
        found = list(itertools.islice(later, 40))
        while (message := next_message(frames))["seq"] <= found[-1]["seq"]:
            direct[message["seq"]] = message
        for message in found:
            self.assertEqual(direct[message["seq"]], message | {"topic": "wavefront"})
        self.check_current(40)
        pair = {}
        for message, binary in self.messages():
            if message["schema"] in ("ovws.image/1", "ovws.spots/1"):
                pair[message["schema"]] = message, binary
            if len(pair) == 2 and len({m["frame_id"] for m, _ in pair.values()}) == 1:
                break
        image, pixels = pair["ovws.image/1"]
        self.assertEqual(len(pixels), image["shape"][0] * image["shape"][1])

    def test_a_browser_that_was_not_there_gets_what_was(self):
        self.message("ovws.status/1")  # from here on ovws-web hears every event
        self.take_reference()
        bins = []
        for message, _ in self.messages():
            bins += [message] if message["schema"] == "ovws.web.trend/1" else []
            if len(bins) == 3:
                break
        got = []
        for message, _ in self.messages():
            got.append(message)
            if message["schema"] == "ovws.web.trend/1" and message not in bins:
                break  # the first one after those that were there
        for one in bins:
            self.assertIn(one, got)
        self.assertTrue(any(message["schema"] == "ovws.event/1" and "reference.take" in message["text"] for message in got))

    def test_one_slow_browser_harms_nobody(self):
        slow = socket.create_connection((HOST, PORT))
        self.addCleanup(slow.close)
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16384)
        slow.sendall(f"GET /stream HTTP/1.1\r\nHost: {ADDRESS}\r\nAuthorization: Bearer {self.tokens['look']}\r\n\r\n".encode())
        sent, others = 0, self.messages()
        while sent < 4 << 20:
            sent += len(next(others)[1])
        self.check_current(40)
        # Stopped, the server adds nothing while the rest is read.
        server = self.bench.process("ovws-web").pid
        self.addCleanup(os.kill, server, signal.SIGCONT)
        os.kill(server, signal.SIGSTOP)
        os.waitid(os.P_PID, server, os.WSTOPPED)
        kept = 0
        slow.settimeout(1.0)
        try:
            while data := slow.recv(1 << 16):
                kept += len(data)
        except TimeoutError:
            pass
        os.kill(server, signal.SIGCONT)
        # Only a buffer of data waits for it, not everything sent to others meanwhile.
        print(f"\n  {kept} bytes waited for it, {sent} were sent to another browser")
        self.assertLess(kept, sent // 2)
        self.assertEqual(self.call("system.status")["counters"]["messages_dropped"], 0)

    def daemon_serves(self, streams):
        """Connections to the daemon's streams, and requests in five seconds, while these browsers read."""
        statuses, requests = self.stream("status"), []
        while len(requests) < 6:
            for stream in streams:
                next(stream)
            if (message := statuses.next(0.0)) is not None:
                requests.append(message["counters"]["requests"])
        listed = subprocess.run(["ss", "-Htn", "state", "established", "( sport = :7701 or sport = :7703 )"], capture_output=True, text=True, check=True)
        statuses.close()
        return len(listed.stdout.splitlines()), requests[-1] - requests[0]

    def test_further_browsers_cost_the_daemon_nothing(self):
        """What the first one costs: tests/bench/browser_cost."""
        streams = [self.messages()]
        self.health(lambda message: message["browsers"] >= 1)
        connections, requests = self.daemon_serves(streams)
        streams += [self.messages() for _ in range(7)]
        more_connections, more_requests = self.daemon_serves(streams)
        self.health(lambda message: message["browsers"] >= 8)
        print(f"\n  one browser: {connections} connections, {requests} requests in 5 s; eight: {more_connections}, {more_requests}")
        self.assertEqual(more_connections, connections)
        self.assertGreater(requests, 0)
        self.assertLess(more_requests, 2 * requests + 4)

    def test_commands_and_the_daemons_own_refusals(self):
        applied = self.command("camera.set", {"gain_db": 6})["result"]["applied"]
        self.assertEqual(applied["gain_db"], 6.0)
        error = self.command("camera.set", {"gain_db": 1000})["error"]
        self.assertEqual((error["data"]["field"], error["data"]["max"]), ("gain_db", 100.0))
        with self.assertRaises(Refused):
            self.command("camera.set", {"gain_db": 6}, right="look")
        bench, _ = self.message("ovws.web.bench/1", lambda m: m["camera"]["settings"]["gain_db"] == 6.0)
        self.assertEqual(bench["camera"]["limits"], self.call("camera.get")["limits"])

    def test_the_holograms_picture_is_the_hologram(self):
        shown = [("aberration.set", {"modes": [{"j": 3, "waves": 0.37}, {"j": 7, "waves": -0.11}]}), ("correction.set", {"modes": [{"j": 3, "waves": 0.2}]}),
                 ("slm.show", {"pattern": "grating"}), ("slm.show", {"pattern": "identify"})]
        for method, params in shown:
            with self.subTest(method=method, params=params):
                self.check_picture(self.call(method, params)["hologram_id"])
        self.call("correction.clear")
        self.call("aberration.set", {"modes": []})
        for job in ("registration.run", "flatness.run"):
            self.run_job(job, {"frames": 2})
        self.check_picture(self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.37}]})["hologram_id"])

    def check_picture(self, hologram_id):
        """Checks that the page's picture and the picture on the SLM are that of the hologram, pixel by pixel."""
        self.message("ovws.web.bench/1", lambda m: m["hologram"]["hologram_id"] == hologram_id)
        verdict = self.call("slm.verify")
        self.assertTrue(verdict["equal"])
        # ovws-web asks one question after the other: between them the hologram may have changed, which the next ones tell.
        self.message("ovws.web.bench/1", lambda m: m["hologram"]["crc32"] == verdict["crc32_shown"])
        status, _, png = self.ask("GET", "/hologram.png", token=self.tokens["look"])
        self.assertEqual(status, 200)
        grey = numpy.asarray(Image.open(BytesIO(png)))
        self.assertEqual((grey.shape, zlib.crc32(grey.tobytes())), ((768, 1280), verdict["crc32"]))

    def test_a_daemon_that_goes_and_comes_again(self):
        self.take_reference()
        self.health(lambda m: m["findings"][0]["wellness"] != "bad")  # a busy machine's frames may be late
        self.bench.stop("ovwsd")
        silent = self.health(lambda m: m["findings"][0]["text"].startswith("The daemon is silent"))
        self.assertEqual([finding["wellness"] for finding in silent["findings"]], ["bad"])
        self.start_daemon()
        self.wait_until("running")
        self.health(lambda m: any("No reference" in finding["text"] for finding in m["findings"]))
        self.assertTrue(self.wavefronts(3))

    def hold_daemon(self):
        """Stops the daemon with SIGSTOP; it answers nothing until `os.kill(pid, SIGCONT)`."""
        pid = self.bench.process("ovwsd").pid
        os.kill(pid, signal.SIGSTOP)
        self.addCleanup(os.kill, pid, signal.SIGCONT)
        os.waitid(os.P_PID, pid, os.WSTOPPED)  # waits until all threads have stopped
        return pid

    def answered(self, connections):
        """Those with an answer. The server answers after ten seconds if the daemon does not."""
        return select.select([connection.sock for connection in connections], [], [], 0)[0]

    def send_command(self, method, params=None):
        """Sends a command without reading the reply; returns the connection."""
        connection = http.client.HTTPConnection(HOST, PORT, timeout=PATIENCE_S)
        self.addCleanup(connection.close)
        body = json.dumps({"method": method, "params": params or {}})
        connection.request("POST", "/rpc", body, {"Authorization": f"Bearer {self.tokens['control']}"})
        return connection

    def test_calls_that_wait_do_not_hold_up_its_end(self):
        self.hold_daemon()
        stream = self.messages()
        next(stream)
        calls = [self.send_command("reference.get") for _ in range(50)]
        for connection in calls[:25]:
            connection.close()
        server = self.bench.process("ovws-web").popen
        server.terminate()
        self.assertEqual(server.wait(PROGRAM_PATIENCE_S), 0)
        for connection in calls[25:]:  # it did not wait for the daemon, of which it would tell after ten seconds
            with self.assertRaises(ConnectionError):
                connection.getresponse()

    def test_the_call_of_a_browser_that_left_is_not_made(self):
        daemon = self.hold_daemon()
        under_way = [self.send_command("loop.get") for _ in range(4)]
        wait_for(lambda: unread(ESTABLISHED) == 4 * [0], what="four calls under way")
        left = [self.send_command("aberration.set", {"modes": [{"j": 3, "waves": 0.3}]}) for _ in range(50)]
        stays = self.send_command("camera.set", {"gain_db": 6})
        wait_for(lambda: unread(ESTABLISHED) == 55 * [0], what="51 calls that wait")
        for connection in left:
            connection.close()
        wait_for(lambda: len(unread(ESTABLISHED)) == 5 and not unread(CLOSE_WAIT), what="the end of the connections that were left")
        self.assertEqual(self.answered(under_way), [])
        self.assertEqual(self.ask("GET", "/")[0], 200)
        os.kill(daemon, signal.SIGCONT)
        for connection in (*under_way, stays):
            self.assertIn("result", json.loads(connection.getresponse().read()))
        self.assertEqual(self.call("camera.get")["settings"]["gain_db"], 6.0)
        self.assertEqual(self.call("aberration.get")["modes"], [])

    def test_links_are_kept_in_a_file(self):
        self.bench.stop("ovws-web")
        path = self.bench.directory / "links"
        self.bench.start("ovws-web", [self.bench.programs / "ovws-web", "--links", path]).wait_for_line("ready")
        name, link = path.read_text().split()
        self.assertEqual((name, path.stat().st_mode & 0o777), ("look", 0o600))
        self.assertNotIn(link, (self.bench.directory / "ovws-web.out").read_text())
        self.assertEqual(self.ask("GET", "/hologram.png", token=link.partition("#")[2])[0] // 100, 2)
        self.assertEqual(self.bench.stop("ovws-web"), 0)

    def test_a_wrong_command_line(self):
        self.bench.stop("ovws-web")
        for arguments in (["--listen", "0.0.0.0:7704"], ["--listen", "nonsense"], ["--listen", "127.0.0.1:7702"]):
            process = self.bench.start("wrong", [self.bench.programs / "ovws-web", *arguments])
            self.assertEqual(process.popen.wait(PROGRAM_PATIENCE_S), 1, arguments)
            self.assertIn("--listen", process.log_path.read_text())


if __name__ == "__main__":
    main()

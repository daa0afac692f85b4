"""Access control: without valid keys there is no reply and no stream, and attempts are counted; rights of each client."""
import json
import os
import socket
import stat
import subprocess
import threading
import time

from case import PATIENCE_S, PROGRAM_PATIENCE_S, BenchCase, Client, ClientError, Stream, main, wait_for

FORBIDDEN = -32003
CONTROL_PORT = 7702


class Recorder:
    """A relay on its own port that records what the client sends over its first connection."""

    def __init__(self, port):
        self.sent = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.endpoint = "tcp://127.0.0.1:%d" % self._listener.getsockname()[1]
        self._port = port
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        client, _ = self._listener.accept()
        server = socket.create_connection(("127.0.0.1", self._port))
        with client, server:
            threading.Thread(target=self._copy, args=(server, client, None), daemon=True).start()
            self._copy(client, server, self.sent)

    @staticmethod
    def _copy(source, target, kept):
        try:
            while data := source.recv(65536):
                if kept is not None:
                    kept.append(data)
                target.sendall(data)
        except OSError:
            pass  # the other side has closed

    def close(self):
        self._listener.close()


class Secured(BenchCase):
    """A daemon with keys and three clients; neither camera nor display unless a test starts them."""

    def start(self):
        self.calls = 0
        self.folder = self.bench.directory
        self.server_key = self.keygen("daemon")
        self.public = {name: self.keygen(name) for name in ("boss", "guest", "leaver", "stranger")}
        self.write_clients("boss", "guest", "leaver")
        # As in daemon/guide/remote-access.md: reachable from other machines.
        self.daemon_config = {"security": {"secret_key": str(self.folder / "daemon.json"), "clients": str(self.folder / "clients.json")},
                              "stream": {"endpoint": "tcp://*:7701", "image_endpoint": "tcp://*:7703"}, "control": {"endpoint": "tcp://*:7702"}}
        self.bench.start_daemon(self.daemon_config)
        self.client = self.connect("boss")

    def keygen(self, name):
        return subprocess.run([self.bench.programs / "ovws", "keygen", "-o", self.folder / f"{name}.json"],
                              check=True, capture_output=True, text=True).stdout.strip()

    def write_clients(self, *names):
        clients = [{"name": n, "key": self.public[n], "role": "read" if n == "guest" else "control"} for n in names]
        new = self.folder / "clients.new"
        new.write_text(json.dumps({"clients": clients}))
        new.rename(self.folder / "clients.json")

    def connect(self, name, server_key=None, endpoint="tcp://127.0.0.1:7702", timeout_s=PATIENCE_S):
        client = Client(endpoint, timeout_s, self.folder / f"{name}.json", server_key or self.server_key)
        self.addCleanup(client.close)
        return client

    def subscribe(self, name, *topics, endpoint="tcp://127.0.0.1:7701"):
        stream = Stream(topics, endpoint, self.folder / f"{name}.json", self.server_key)
        self.addCleanup(stream.close)
        return stream

    def call(self, method, params=None):
        self.calls += 1
        return super().call(method, params)

    def rejected(self):
        return self.call("system.status")["counters"]["clients_rejected"]

    def assert_rejected(self, before, what):
        wait_for(lambda: self.rejected() > before, what=f"the count of {what}")

    def assert_shut_out(self, connect, what):
        before = self.rejected()
        client = connect()
        self.addCleanup(client.close)
        with self.assertRaises(ClientError) as caught:
            client.call("system.status")
        self.assertIsNone(caught.exception.code, "no daemon's answer")
        self.assert_rejected(before, what)

    def test_control_and_streams_for_who_has_a_key(self):
        self.assertEqual(self.call("system.status")["counters"]["clients_rejected"], 0)
        self.assertIsNotNone(self.subscribe("guest", "status").next(PATIENCE_S))

    def test_the_doctor_finds_a_daemon_at_all_addresses(self):
        done = self.run_ovws("--json", "--key", self.folder / "boss.json", "--server-key", self.server_key, "doctor", "--config", self.folder / "ovwsd.json")
        findings = {one["name"]: one for one in json.loads(done.stdout)["findings"]}
        self.assertEqual(findings["daemon.answer"]["verdict"], "ok", findings["daemon.answer"])
        self.assertIn("tcp://127.0.0.1:7702", findings["daemon.answer"]["meaning"])
        self.assertEqual(findings["configuration"]["verdict"], "ok", findings["configuration"])

    def test_who_has_no_right_key_gets_nothing_and_is_counted(self):
        begin = time.monotonic()
        self.assert_shut_out(lambda: self.connect("stranger", timeout_s=1.0), "a client that is not known")
        self.assert_shut_out(lambda: Client(timeout_s=1.0), "a client without keys")
        self.assert_shut_out(lambda: self.connect("boss", server_key=self.public["guest"], timeout_s=1.0), "a client of another daemon")
        for endpoint in ("tcp://127.0.0.1:7701", "tcp://127.0.0.1:7703"):
            before = self.rejected()
            stranger = self.subscribe("stranger", "", endpoint=endpoint)
            self.assert_rejected(before, f"a stranger at {endpoint}")
            before = self.rejected()
            bare = Stream([""], endpoint)
            self.addCleanup(bare.close)
            self.assert_rejected(before, f"a bare subscriber at {endpoint}")
            self.assertIsNone(stranger.next(1.5))
            self.assertIsNone(bare.next(0.1))
        event = self.folder / "ovwsd.log"
        wait_for(lambda: "client rejected" in event.read_text(), what="the line of the log")
        self.assertLessEqual(event.read_text().count("client rejected"), 1 + (time.monotonic() - begin) / 10.0, "a line in ten seconds, not one for each")

    def test_a_handshake_played_back_gets_nothing(self):
        relay = Recorder(CONTROL_PORT)
        self.addCleanup(relay.close)
        good = self.connect("boss", endpoint=relay.endpoint)
        requests = good.call("system.status")["counters"]["requests"]
        self.calls = 0
        recorded = list(relay.sent)
        self.assertGreaterEqual(len(recorded), 3, "greeting, HELLO, INITIATE, request")
        before = self.rejected()
        with socket.create_connection(("127.0.0.1", CONTROL_PORT)) as replay:
            replay.settimeout(5.0)
            received = b""
            try:
                for data in recorded:
                    replay.sendall(data)
                while data := replay.recv(65536):
                    received += data
            except OSError:
                pass  # closed by the daemon
        self.assert_rejected(before, "a handshake played back")
        self.assertNotIn(b"READY", received)
        now = self.call("system.status")["counters"]["requests"]
        self.assertEqual(now - requests, self.calls, "no request but our own")
        good.call("system.status")

    def test_who_may_read_changes_nothing(self):
        guest = self.connect("guest")
        described = guest.call("system.describe")
        roles = described["roles"]
        self.assertEqual(set(roles), set(described["methods"]), "each method has a role")
        reading = {m for m in roles if m.endswith((".get", ".list")) or m.startswith("system.")} | {"slm.verify", "camera.grab", "loop.model", "record.estimate", "slm.outputs"}
        self.assertEqual({m for m, role in roles.items() if role == "read"}, reading)
        for method in sorted(set(roles) - reading):
            with self.assertRaises(ClientError, msg=method) as caught:
                guest.call(method)
            self.assertEqual((caught.exception.code, caught.exception.data["field"]), (FORBIDDEN, "method"), method)
            self.assertIn("read", caught.exception.data["reason"])
        for method in ("config.get", "sensor.get", "system.status"):
            guest.call(method)
        self.assertNotEqual(self.refused("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]}).code, FORBIDDEN)

    def refusal_of(self, client):
        """The error of the first call that is refused: a busy disk may delay the reading of the file."""
        def refused():
            try:
                client.call("system.status")
            except ClientError as error:
                return error
            return None
        return wait_for(refused, what="the refusal")

    def is_shut_out(self, name):
        try:
            self.connect(name, timeout_s=1.0).call("system.status")
        except ClientError:
            return True
        return False

    def test_a_key_that_is_withdrawn(self):
        leaver = self.connect("leaver")
        leaver.call("system.status")
        streams = {name: self.subscribe(name, "status") for name in ("leaver", "guest")}
        for stream in streams.values():
            self.assertIsNotNone(stream.next(PATIENCE_S))
        before = self.rejected()
        self.write_clients("boss", "guest")
        self.assertEqual(self.refusal_of(leaver).code, FORBIDDEN)
        self.assertGreater(self.rejected(), before)
        streams["leaver"].drain()
        streams["guest"].drain()
        seq = wait_for(lambda: (m := streams["guest"].next(0.5)) and m["seq"], what="the stream of who stays")
        wait_for(lambda: (m := streams["guest"].next(0.5)) and m["seq"] > seq + 1, what="the stream of who stays")
        while (late := streams["leaver"].next(0.1)) is not None:  # both may have had one on its way
            self.assertLessEqual(late["seq"], seq, "no message once the others received again")
        self.assertIsNone(streams["leaver"].next(2.5))
        self.assert_shut_out(lambda: self.connect("leaver", timeout_s=1.0), "the withdrawn key")
        self.write_clients("boss", "guest", "leaver")
        self.assertIsNotNone(streams["leaver"].next(PATIENCE_S), "the same socket, once its key is known again")

    def test_a_file_of_clients_that_is_wrong_changes_nothing(self):
        events = self.subscribe("boss", "event", "status")
        self.assertIsNotNone(events.next(PATIENCE_S))
        (self.folder / "clients.json").write_text('{"clients": [{"name": "boss"')
        found = wait_for(lambda: (m := events.next(0.2)) and m["topic"] == "event" and m["kind"] == "client" and m, what="the event")
        self.assertEqual(found["severity"], "error")
        self.assertIn("clients.json", found["text"])
        self.connect("guest").call("system.status")
        self.write_clients("boss")
        wait_for(lambda: self.is_shut_out("guest"), what="the refusal")

    def test_the_command_line_says_what_is_missing(self):
        def ovws(*arguments, **env):
            return subprocess.run([self.bench.programs / "ovws", "--timeout", "5", *arguments, "status"], capture_output=True, text=True,
                                  timeout=PROGRAM_PATIENCE_S, env=os.environ | env)

        good = ovws("--key", self.folder / "guest.json", "--server-key", self.server_key)
        self.assertEqual(good.returncode, 0, good.stderr)
        self.assertEqual(ovws(OVWS_KEY=str(self.folder / "guest.json"), OVWS_SERVER_KEY=self.server_key).returncode, 0)
        for arguments, words in (((), "--key"),
                                 (("--key", self.folder / "guest.json"), "public key"),
                                 (("--server-key", self.server_key), "--key"),
                                 (("--key", self.folder / "none.json", "--server-key", self.server_key), "none.json"),
                                 (("--key", self.folder / "stranger.json", "--server-key", self.server_key), "security.clients"),
                                 (("--key", self.folder / "guest.json", "--server-key", self.public["boss"]), "server key")):
            with self.subTest(words=words):
                done = ovws(*arguments)
                print("\n  ", done.stderr.strip())
                self.assertEqual(done.returncode, 3)
                self.assertIn(words, done.stderr)

    def test_pictures_of_a_mebibyte(self):
        self.bench.stop("ovwsd")
        self.bench.start_display()
        self.bench.start_twin({})
        roi = {"x": 0, "y": 0, "width": 1024, "height": 1024}
        self.bench.start_daemon(self.daemon_config | {"camera": {"roi": roi, "frame_rate_hz": 10.0, "transfer_ms": 100.0}})
        self.wait_until("running")
        pictures = self.subscribe("guest", "image", endpoint="tcp://127.0.0.1:7703")
        for _ in range(3):
            message = pictures.next(PATIENCE_S)
            self.assertIsNotNone(message)
            self.assertEqual((message["shape"], len(message["binary"])), ([1024, 1024], 1 << 20))


class Files(BenchCase):
    """Configurations refused at the start, and the files of keys and sockets."""

    def start(self):
        self.folder = self.bench.directory

    def ovws(self, *arguments):
        return subprocess.run([self.bench.programs / "ovws", *arguments], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, cwd=self.folder)

    def complaint(self, config, *arguments):
        path = self.folder / "checked.json"
        path.write_text(json.dumps(config))
        done = subprocess.run([self.bench.programs / "ovwsd", "--config", path, *arguments], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(done.returncode, 1, done.stderr)
        print("\n  ", done.stderr.strip()[-300:])
        return done.stderr

    def test_only_this_machine_without_keys(self):
        for section, key in (("control", "endpoint"), ("stream", "endpoint"), ("stream", "image_endpoint")):
            for endpoint in ("tcp://*:7799", "tcp://0.0.0.0:7799", "tcp://127.0.0.1.example.org:7799", "ipc://@ovws"):
                for arguments in ((), ("--check-config",)):
                    text = self.complaint({section: {key: endpoint}}, *arguments)
                    self.assertIn(f"{section}.{key}: ", text)
                    self.assertIn("security.secret_key", text)

    def test_files_that_are_no_secret(self):
        self.assertEqual(self.ovws("keygen", "-o", "key.json").returncode, 0)
        key, clients = self.folder / "key.json", self.folder / "clients.json"
        clients.write_text('{"clients": []}')
        config = {"security": {"secret_key": str(key), "clients": str(clients)}}
        key.chmod(0o640)
        self.assertIn("security.secret_key", text := self.complaint(config, "--check-config"))
        self.assertIn("chmod 600", text)
        key.chmod(0o600)
        clients.chmod(0o646)
        self.assertIn("security.clients", self.complaint(config))
        clients.chmod(0o644)
        for wrong in ('{"clients": [{"name": "a", "key": "short", "role": "read"}]}', '{"clients": [{"name": "a", "role": "reed"}]}', "{}"):
            clients.write_text(wrong)
            self.assertIn("security.clients", self.complaint(config, "--check-config"))
        self.assertIn("security.clients", self.complaint({"security": {"secret_key": str(key)}}, "--check-config"))
        keys = json.loads(key.read_text())
        key.write_text(json.dumps(keys | {"public_key": keys["public_key"][::-1]}))
        self.assertIn("ovws keygen", self.complaint(config, "--check-config"))

    def test_keygen_writes_a_secret_once(self):
        self.addCleanup(os.umask, os.umask(0))
        first = self.ovws("keygen", "-o", "a.json")
        path = self.folder / "a.json"
        self.assertEqual(stat.S_IMODE(path.stat().st_mode), 0o600)
        text = path.read_text()
        self.assertEqual(json.loads(text)["public_key"], first.stdout.strip())
        again = self.ovws("keygen", "-o", "a.json")
        self.assertEqual(again.returncode, 1)
        self.assertIn("a.json", again.stderr)
        self.assertEqual(path.read_text(), text)
        path.chmod(0o644)
        printed = json.loads(self.ovws("--json", "keygen", "-o", "a.json", "--replace", "--server-key", first.stdout.strip()).stdout)
        written = json.loads(path.read_text())
        self.assertEqual((written["public_key"], written["server_key"]), (printed["public_key"], first.stdout.strip()))
        self.assertNotIn(written["public_key"], text)
        self.assertEqual(stat.S_IMODE(path.stat().st_mode), 0o600)

    def test_the_file_of_a_socket(self):
        self.addCleanup(os.umask, os.umask(0))
        endpoints = {name: f"ipc://{self.folder}/{name}.socket" for name in ("control", "numbers", "pictures")}
        self.bench.start_daemon({"control": {"endpoint": endpoints["control"]},
                                 "stream": {"endpoint": endpoints["numbers"], "image_endpoint": endpoints["pictures"]}})
        for name in endpoints:
            about = (self.folder / f"{name}.socket").stat()
            self.assertEqual((stat.S_IMODE(about.st_mode), about.st_gid), (0o660, os.getegid()))
        client = Client(endpoints["control"])
        self.addCleanup(client.close)
        self.assertEqual(client.call("system.status")["counters"]["clients_rejected"], 0)

    def test_ipv6_addresses(self):
        if not os.path.exists("/proc/net/if_inet6"):
            self.skipTest("this machine has no IPv6")
        keys = {name: self.ovws("keygen", "-o", f"{name}.json").stdout.strip() for name in ("daemon", "client")}
        (self.folder / "clients.json").write_text(json.dumps({"clients": [{"name": "a", "key": keys["client"], "role": "control"}]}))
        security = {"security": {"secret_key": "daemon.json", "clients": "clients.json"}}
        given = (self.folder / "client.json", keys["daemon"])
        for host, more, key in (("[::1]", {}, ()), ("[::]", security, given)):
            with self.subTest(host):
                self.bench.start_daemon(more | {"control": {"endpoint": f"tcp://{host}:7702"},
                                                "stream": {"endpoint": f"tcp://{host}:7701", "image_endpoint": f"tcp://{host}:7703"}})
                options = ["--key", key[0], "--server-key", key[1]] if key else []
                done = self.ovws("--endpoint", "tcp://[::1]:7702", "--timeout", str(PATIENCE_S), *options, "status")
                self.assertEqual(done.returncode, 0, done.stderr)
                with Client("tcp://[::1]:7702", PATIENCE_S, *key) as client:
                    self.assertEqual(client.call("config.get")["control"]["endpoint"], f"tcp://{host}:7702")
                stream = Stream(["status"], "tcp://[::1]:7701", *key)
                self.addCleanup(stream.close)
                self.assertIsNotNone(stream.next(PATIENCE_S))
                self.bench.stop("ovwsd")

    def test_streams_end_on_ipc_too(self):
        keys = {}
        for name in ("daemon", "stays", "goes"):
            keys[name] = self.ovws("keygen", "-o", f"{name}.json").stdout.strip()

        def write(*names):
            clients = [{"name": n, "key": keys[n], "role": "control"} for n in names]
            (self.folder / "clients.new").write_text(json.dumps({"clients": clients}))
            (self.folder / "clients.new").rename(self.folder / "clients.json")

        write("stays", "goes")
        sockets = self.folder / "sockets"
        sockets.mkdir()
        endpoint = f"ipc://{sockets}/numbers.socket"
        self.bench.start_daemon({"stream": {"endpoint": endpoint},
                                 "security": {"secret_key": str(self.folder / "daemon.json"), "clients": str(self.folder / "clients.json")}})
        stays, goes = (Stream(["status"], endpoint, self.folder / f"{n}.json", keys["daemon"]) for n in ("stays", "goes"))
        self.addCleanup(stays.close)
        self.addCleanup(goes.close)
        self.assertIsNotNone(stays.next(PATIENCE_S))
        self.assertIsNotNone(goes.next(PATIENCE_S))
        for _ in range(3):  # the socket file is removed and recreated each time
            write("stays")
            wait_for(lambda: goes.next(1.6) is None, what="the end of the stream")
            self.assertIsNotNone(stays.next(PATIENCE_S))
            write("stays", "goes")
            goes.close()
            goes = Stream(["status"], endpoint, self.folder / "goes.json", keys["daemon"])
            self.addCleanup(goes.close)
            self.assertIsNotNone(goes.next(PATIENCE_S))
        self.assertEqual(stat.S_IMODE((sockets / "numbers.socket").stat().st_mode), 0o660)
        sockets.rename(self.folder / "away")
        write("stays")
        wait_for(lambda: f"{endpoint} cannot be bound again" in self.bench.log("ovwsd"), what="the line of the log")
        (self.folder / "away").rename(sockets)
        wait_for(lambda: f"the stream at {endpoint} is open again" in self.bench.log("ovwsd"), what="its end")
        self.assertIsNotNone(stays.next(PATIENCE_S))


if __name__ == "__main__":
    main()

"""ovws doctor on a healthy bench and with a fault for each check: correct findings, working fixes, no disturbance."""
import json
import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

import screen
from case import PROGRAM_PATIENCE_S, BenchCase, main, next_message, own_mounts, wait_for

SLM = (1920, 0, 1280, 768)  # on the desktop
VERDICTS = {"ok", "note", "warning", "fault", "not_here"}
NOBODY = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--bounding-set=-all", "--inh-caps=-all"]
ALONE = ["unshare", "--pid", "--fork", "--mount-proc"]  # hides services of this machine


class DoctorCase(BenchCase):
    """`examine` runs the doctor with the configuration of `config`."""

    timeout_s = 0.5  # of an answer of the daemon

    def setUp(self):
        own_mounts()
        super().setUp()

    def run_doctor(self, *arguments, config=None, before=(), program=None, env=None, named=True):
        path = self.bench.directory / "doctor.json"
        path.write_text(config if isinstance(config, str) else json.dumps(config or self.config()))
        file = ["--config", path] if named else []
        command = [*before, program or self.bench.programs / "ovws", "--timeout", str(self.timeout_s), "doctor", *file, *arguments]
        return subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, env=env or self.environment(),
                              cwd="/")

    def environment(self):
        return {"PATH": os.environ["PATH"], "DISPLAY": self.bench.display}

    def config(self):
        return {"state": {"directory": str(self.bench.directory / "state")}}

    def examine(self, *arguments, **more):
        """The findings by name. Also checks the JSON document and the exit status."""
        done = self.run_doctor("--json", *arguments, **more)
        self.assertEqual(done.stderr, "")
        document = json.loads(done.stdout)
        self.assertEqual(document["schema"], "ovws.doctor/1")
        findings = {one["name"]: one for one in document["findings"]}
        self.assertEqual(len(findings), len(document["findings"]))
        for one in findings.values():
            self.assertIn(one["verdict"], VERDICTS, one)
            self.assertTrue(one["meaning"], one)
            if one["verdict"] in ("warning", "fault"):
                self.assertTrue(one["fix"], one)
        for verdict in VERDICTS:
            self.assertEqual(document["counts"][verdict], sum(one["verdict"] == verdict for one in findings.values()))
        self.assertEqual(done.returncode, 1 if document["counts"]["fault"] else 0)
        return findings

    def examine_for(self, faults, **more):
        """The findings, once these are the faults: on a busy machine the camera or the X server may not answer in the doctor's own time."""
        def found():
            findings = self.examine(**more)
            print("\n  faults:", *(findings[name] for name in self.faults(findings)))
            return self.faults(findings) == faults and findings
        return wait_for(found, what=f"the faults {faults}")

    def check(self, findings, name, verdict, *words):
        one = findings[name]
        print(f"\n  {name}: {one['verdict']}: {one['meaning']}\n    fix: {one['fix']}")
        self.assertEqual(one["verdict"], verdict, one)
        for word in words:
            self.assertIn(str(word), one["meaning"] + " " + (one["fix"] or ""))

    def faults(self, findings):
        return {name for name, one in findings.items() if one["verdict"] == "fault"}

    def mount_over(self, folder, name, text):
        """Mounts a tmpfs with this one file over a kernel folder, for this test only."""
        subprocess.run(["mount", "-t", "tmpfs", "none", folder], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", folder], check=True)
        path = Path(folder) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text + "\n")


class Well(DoctorCase):
    """A healthy bench with a running daemon."""

    timeout_s = 5.0

    def start_daemon(self):
        self.daemon_config = self.config()
        super().start_daemon()

    def test_a_bench_that_is_well_and_a_daemon_that_does_not_notice(self):
        self.take_reference()
        frames = self.stream("wavefront")
        self.settled_frames(frames, 5)
        before, seen = self.call("system.status"), screen.grab(self.bench.display, *SLM)
        frames.drain()
        for _ in range(3):
            findings = self.examine_for(set())
            for name in ("configuration", "camera.found", "camera.interface", "camera.packets", "slm.server", "slm.output", "slm.mode",
                         "optics.zeroth_order", "slm.gamma", "slm.power", "slm.screen_saver", "slm.compositor", "state.directory", "daemon.answer",
                         "daemon.version", "daemon.state", "daemon.store", "daemon.job", "camera.state", "camera.light", "camera.saturation",
                         "slm.state", "slm.levels", "sensor.layout"):
                self.check(findings, name, "ok")
            self.check(findings, "camera.control", "ok", "the daemon controls the camera")
            self.check(findings, "camera.usb_memory", "not_here", "network")
        self.assertTrue(all(frame["valid"] for frame in self.settled_frames(frames, 20)))
        after = self.call("system.status")
        self.assertEqual(after["state"], "running")
        self.assertEqual(after["slm"]["hologram_id"], before["slm"]["hologram_id"])
        for name in ("camera_reconnects", "display_faults"):
            self.assertEqual(after["counters"][name], before["counters"][name], name)
        self.assertTrue((screen.grab(self.bench.display, *SLM) == seen).all())

    def test_without_a_file_the_settings_in_use_are_judged(self):
        state = self.bench.directory / "state"
        findings = self.examine(named=False)
        self.check(findings, "configuration", "ok", "the settings that the daemon at tcp://127.0.0.1:7702 uses")
        self.check(findings, "state.directory", "ok", state, "in use by the daemon")
        self.call("camera.set", {"roi": {"x": 0, "y": 0, "width": 64, "height": 64}})
        self.check(self.examine(named=False), "sensor.layout", "fault", "the settings that the daemon uses", "outside")
        self.check(self.examine(), "configuration", "ok")  # the file

    def test_a_dark_and_a_too_bright_image(self):
        self.call("camera.set", {"exposure_us": 20})
        wait_for(lambda: (self.call("system.status")["camera"]["brightest"] or 1.0) < 0.05, what="a dark image")
        self.check(self.examine(), "camera.light", "warning", "% of full scale", "ovws exposure auto")
        self.call("camera.set", {"exposure_us": 8000})
        wait_for(lambda: next_message(self.stream("wavefront"))["saturated"] == 1.0, what="saturated spots")
        self.check(self.examine(), "camera.saturation", "warning", "19 of 19 spots are saturated", "ovws exposure auto")

    def test_real_time_is_what_the_daemon_met(self):
        """The doctor predicts which privileges the same user's daemon lacks."""
        findings, log = self.examine(before=ALONE), self.bench.log("ovwsd")
        for name, refusal in (("realtime.priority", "runs without SCHED_FIFO"), ("realtime.memory", "memory is not locked"),
                              ("cpu.sleep", "/dev/cpu_dma_latency cannot be written")):
            if findings[name]["verdict"] != "not_here":  # not available on this system
                self.assertEqual(findings[name]["verdict"], "warning" if refusal in log else "ok", findings[name])

    def test_a_camera_in_unknown_hands(self):
        findings = self.examine("--endpoint", "tcp://127.0.0.1:7999")
        self.check(findings, "daemon.answer", "not_here", "tcp://127.0.0.1:7999", "systemctl start ovwsd")
        self.check(findings, "camera.control", "warning", "a program controls the camera")

    def test_what_the_daemon_says_is_reported(self):
        subprocess.run(["xrandr", "-display", self.bench.display, "--output", "DUMMY1", "--off"], check=True, capture_output=True)
        wait_for(lambda: self.call("system.status")["slm"]["fault"], what="the fault")
        findings = self.examine()
        self.check(findings, "slm.state", "fault", "switched off")
        self.check(findings, "slm.mode", "fault", "xrandr --output DUMMY1 --mode 1280x768")

    def test_the_output_is_not_read_back_while_the_loop_is_closed(self):
        self.take_reference()
        self.close_loop()
        self.check(self.examine(), "slm.levels", "not_here", "while the loop is closed", "ovws loop open")
        self.call("loop.open")
        self.check(self.examine(), "slm.levels", "ok")

    def test_words_for_a_person(self):
        done = wait_for(lambda: (done := self.run_doctor()).returncode == 0 and done, what="no fault")
        self.assertRegex(done.stdout, r"(?m)^ok +slm\.mode +DUMMY1 shows 1280x768 at 59\.\d Hz")
        self.assertRegex(done.stdout, r"(?m)^0 FAULT, \d+ warning, \d+ note, \d+ ok, \d+ not here$")
        self.assertIn("Exit codes: 0 no fault", self.run_doctor("--help").stdout)
        self.assertEqual(self.run_doctor("--no-such-option").returncode, 2)


class Ill(DoctorCase):
    """No daemon; the tests create the faults."""

    def start(self):
        self.bench.start_display()
        self.bench.start_twin()

    def xrandr(self, *arguments):
        subprocess.run(["xrandr", "-display", self.bench.display, "--output", "DUMMY1", *arguments], check=True, capture_output=True)

    def repair(self, fix):
        """Applies the doctor's fix."""
        subprocess.run(["sh", "-c", fix.replace("sudo ", "")], check=True, capture_output=True, env=self.environment())

    def test_no_camera_and_another_one(self):
        self.check(self.examine_for(set()), "camera.control", "ok", "no program controls the camera")
        serial = self.config() | {"camera": {"id": "no such serial"}}
        self.check(self.examine(config=serial), "camera.found", "fault", '"camera": {"id": "127.0.0.1"}')
        self.bench.stop("ovws-twin")
        findings = self.examine()
        self.check(findings, "camera.found", "fault", "no camera at all")
        self.check(findings, "camera.control", "not_here")
        self.assertEqual(self.faults(findings), {"camera.found"})
        away = self.config() | {"camera": {"id": "192.0.2.7"}}
        self.check(self.examine(config=away), "camera.interface", "fault", "ip address add 192.0.2.1/24")

    def test_the_output_and_the_lines_that_mend_it(self):
        for name, spoil in (("slm.mode", ["--mode", "1024x768"]), ("slm.mode", ["--off"]),
                            ("slm.gamma", ["--gamma", "1:0.8:0.6"]), ("slm.output", ["--same-as", "DUMMY0"])):
            with self.subTest(spoil):
                self.xrandr(*spoil)
                self.repair(self.examine_for({name})[name]["fix"])
                self.examine_for(set())
        wrong = self.config() | {"slm": {"display": "HDMI-7"}}
        self.check(self.examine(config=wrong), "slm.output", "fault", "HDMI-7", '"slm": {"display": "DUMMY1"}')
        desktop = self.config() | {"slm": {"display": "DUMMY0", "width": 1920, "height": 1080}}
        subprocess.run(["xrandr", "-display", self.bench.display, "--output", "DUMMY0", "--primary"], check=True)
        self.check(self.examine(config=desktop), "slm.output", "fault", "primary")

    def test_a_screen_saver_and_no_server(self):
        subprocess.run(["xset", "-display", self.bench.display, "s", "600"], check=True)
        findings = self.examine()
        self.check(findings, "slm.screen_saver", "warning", "600 s")
        self.repair(findings["slm.screen_saver"]["fix"])
        self.check(self.examine(), "slm.screen_saver", "ok")
        path = {"PATH": os.environ["PATH"]}
        self.check(self.examine(env=path), "slm.server", "fault", "export DISPLAY")
        self.check(self.examine(env=path | {"WAYLAND_DISPLAY": "wayland-0"}), "slm.server", "not_here", "wayland")
        self.check(self.examine(env=path | {"DISPLAY": ":987"}), "slm.server", "fault", ":987")

    def test_a_server_that_hangs(self):
        server = self.bench.process("xorg").pid
        os.kill(server, signal.SIGSTOP)
        self.addCleanup(os.kill, server, signal.SIGCONT)
        findings = self.examine_for({"slm.server"})
        self.check(findings, "slm.server", "fault", self.bench.display, "does not answer within 3 s", "restart display-manager")
        self.check(findings, "slm.mode", "not_here")
        for name in ("camera.found", "state.directory"):
            self.check(findings, name, "ok")
        self.check(findings, "daemon.answer", "not_here")

    def test_the_state_folder(self):
        state = self.bench.directory / "state"
        self.check(self.examine(), "state.directory", "ok", "will be created")
        self.assertFalse(state.exists())
        state.mkdir()
        self.check(self.examine(), "state.directory", "ok", "is writable")
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "none", state], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", state], check=True)
        self.check(self.examine(), "state.room", "fault", "MiB left")
        subprocess.run(["mount", "-o", "remount,ro", state], check=True)
        findings = self.examine()
        self.check(findings, "state.directory", "fault", "read-only")
        self.assertEqual(list(state.iterdir()), [])
        wrong = {"state": {"directory": str(self.bench.directory / "doctor.json")}}
        self.check(self.examine(config=wrong), "state.directory", "fault", "is not a folder")
        self.check(self.examine(config={"log": {}}, env=self.environment() | {"STATE_DIRECTORY": str(self.bench.directory)}),
                   "state.directory", "ok", self.bench.directory)

    def test_the_kernel_s_settings(self):
        self.mount_over("/proc/sys/net/core", "rmem_max", "212992")
        self.mount_over("/sys/devices/system/clocksource/clocksource0", "current_clocksource", "hpet")
        self.mount_over("/sys/devices/system/cpu", "cpu0/cpufreq/scaling_governor", "powersave")
        findings = self.examine()
        self.check(findings, "camera.socket_buffer", "warning", "212992", "sysctl -w net.core.rmem_max=4194304")
        self.check(findings, "clock.source", "warning", "hpet")
        self.check(findings, "cpu.governor", "warning", "powersave", "scaling_governor")
        Path("/proc/sys/net/core/rmem_max").write_text("4194304\n")
        Path("/sys/devices/system/clocksource/clocksource0/current_clocksource").write_text("tsc\n")
        Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor").write_text("performance\n")
        findings = self.examine()
        for name in ("camera.socket_buffer", "clock.source", "cpu.governor"):
            self.check(findings, name, "ok")

    def test_packets_that_the_interface_does_not_take(self):
        subprocess.run(["ip", "link", "set", "lo", "mtu", "1500"], check=True)
        self.addCleanup(subprocess.run, ["ip", "link", "set", "lo", "mtu", "65536"], check=True)
        findings = self.examine_for(set())
        self.check(findings, "camera.packets", "warning", "1500")
        self.repair(findings["camera.packets"]["fix"])
        self.check(self.examine_for(set()), "camera.packets", "ok")

    def test_the_configuration(self):
        unknown = self.examine(config={"camera": {"exposure_su": 3}})
        self.check(unknown, "configuration", "fault", '"exposure_us" in place of "exposure_su"')
        for name in ("camera", "slm", "state"):
            self.check(unknown, name, "not_here")
        self.check(self.examine(config="{ nonsense"), "configuration", "fault", "sudoedit")
        unusable = self.examine(config=self.config() | {"slm": {"lut": "/nowhere/lut.txt"}})
        self.check(unusable, "configuration", "fault", "/nowhere/lut.txt")
        self.check(unusable, "camera.found", "ok")  # checks that do not need the LUT still run
        done = self.run_doctor("--config", "/nowhere.json")
        self.assertEqual(done.returncode, 2, "an option given twice")

    def test_a_user_without_rights(self):
        with tempfile.TemporaryDirectory(dir="/tmp") as folder:
            os.chmod(folder, 0o755)
            program = Path(shutil.copy(self.bench.programs / "ovws", folder))
            config = Path(folder) / "ovwsd.json"
            state = Path(folder) / "state"
            state.mkdir(0o755)
            limits = [*ALONE, "prlimit", "--rtprio=0", "--memlock=8388608", *NOBODY]

            def examine(keys):
                config.write_text(json.dumps({"state": {"directory": str(state)}} | keys))
                done = subprocess.run([*limits, program, "--timeout", "0.5", "--json", "doctor", "-c", config], capture_output=True,
                                      text=True, timeout=PROGRAM_PATIENCE_S, env=self.environment(), cwd="/")
                self.assertEqual(done.stderr, "")
                return {one["name"]: one for one in json.loads(done.stdout)["findings"]}

            for keys, verdict in (({}, "warning"), ({"realtime": "enforce"}, "fault")):
                findings = examine(keys)
                self.check(findings, "camera.found", "ok")
                self.check(findings, "realtime.priority", verdict, "rtprio 90")
                self.check(findings, "realtime.memory", verdict, "8 MiB")
                self.check(findings, "state.directory", "not_here", "root")


if __name__ == "__main__":
    main()

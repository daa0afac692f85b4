"""Many machines: the result of a study and of a replay does not depend on the number of parts, nor on what was killed on the way."""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import textwrap
import unittest

import slurm
from case import PROGRAM_PATIENCE_S, ROOT, BenchCase, bench_module, main, wait_for

CLUSTER = ROOT / "config" / "cluster"
GUIDE = ROOT / "daemon" / "guide" / "cluster.md"
STUDY = ("localisation", "--quick")
SNAKEMAKE = shutil.which("snakemake", path="/usr/bin")


def contents(folder):
    """The files of a result that must be the same everywhere, by name."""
    files = {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir() if path.is_file()}
    facts = json.loads(files.pop("provenance.json"))
    assert facts["host"] and facts["begun_utc"] and facts["command"], facts
    return files


class Cluster(BenchCase):
    small = True
    daemon_config = {"camera": {"frame_rate_hz": 100}, "record": {"directory": "recordings"},
                     "refine": {"electrons_per_dn": 10000 / 255, "black_level_dn": 2.0}}

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = tempfile.TemporaryDirectory(prefix="ovws-cluster-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.recording = cls.folder / "run-1.h5"
        cls.programs = bench_module.find_programs()
        cls.env = dict(os.environ, CI="true", PATH=f"{cls.programs}:/usr/bin:/usr/sbin:/bin")  # with CI Snakemake polls faster

    def setUp(self):
        """The first test makes the recording, with a change of the aberration in the middle, and of the frames' templates."""
        if self.recording.exists():
            return
        super().setUp()
        self.take_reference(20)
        stream = self.stream("wavefront")
        first = self.fitted_frames(stream, 1)[0]["seq"]
        self.call("record.start", {"name": "run-1"})
        self.recorded_frames(40)
        shown = self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.2}]})["hologram_id"]
        last = self.settled_frames(stream, 10, shown)[-1]["seq"]
        frames = self.recorded_frames(max(90, last - first))["frames"]
        self.call("record.stop")
        self.assertGreaterEqual(frames, 90)
        shutil.move(self.bench.directory / "recordings" / "run-1.h5", self.recording)
        self.bench.close()

    def report_failure(self):
        pass  # the bench has ended

    def ovws(self, *arguments, status=0):
        done = subprocess.run([self.programs / "ovws", *map(str, arguments)], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, cwd=self.folder)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def joined(self, command, shards, name):
        """The contents of the folder NAME, to which the shards of a command are joined."""
        for number in range(1, shards + 1):
            self.ovws(*command, "--shard", f"{number}/{shards}", "-o", f"{name}-parts")
        parts = sorted((self.folder / f"{name}-parts").glob("*.jsonl"), reverse=True)
        self.ovws("merge", *parts, "-o", name)
        return contents(self.folder / name)

    def whole(self):
        """The results of one machine: of the study alone, and of the replay in one part."""
        if not (self.folder / "alone").exists():
            self.ovws("study", *STUDY, "-o", "alone")
            self.joined(("replay", self.recording, "--refine"), 1, "replayed")
        return contents(self.folder / "alone"), contents(self.folder / "replayed")

    def test_1_2_and_7_shards_give_the_same_bytes(self):
        study, replay = self.whole()
        self.assertGreaterEqual(study.keys(), {"summary.json", "localisation.png", "localisation.csv", "localisation.gnuplot"})
        for shards in (1, 2, 7):
            self.assertEqual(self.joined(("study", *STUDY), shards, f"study-{shards}"), study)
            self.assertEqual(self.joined(("replay", self.recording, "--refine"), shards, f"replay-{shards}"), replay)
        summary = json.loads(replay["summary.json"])
        print("\n ", {key: summary[key] for key in ("frames", "replayed", "same", "valid", "refined")})
        self.assertEqual((summary["same"], summary["frames"]), (summary["replayed"], summary["recording"]["frames"]))
        self.assertGreater(summary["refined"], 0.5 * summary["valid"])
        lines = [json.loads(line) for line in replay["frames.jsonl"].splitlines()]
        self.assertEqual([line["row"] for line in lines], list(range(summary["frames"])))
        waves = [line["refined"]["coefficients"][2] for line in lines if line["refined"] and line["refined"]["valid"]]
        self.assertAlmostEqual(waves[0], 0.0, delta=0.01)
        self.assertAlmostEqual(waves[-1], 0.2, delta=0.02)

    def test_ranges_of_frames(self):
        frames = len(self.whole()[1]["frames.jsonl"].splitlines())
        whole = self.ovws("replay", self.recording, "--frames").splitlines()
        self.assertEqual(self.ovws("replay", self.recording, "--frames", "17:20").splitlines()[:-1], whole[17:20])
        self.assertIn(f"has the frames 0:{frames}", self.ovws("replay", self.recording, "--frames", f"0:{frames + 1}", status=1))
        self.assertIn("A:B", self.ovws("replay", self.recording, "--frames", "3", status=2))
        self.ovws("replay", self.recording, "--frames", "0:10", "-o", "ranges")
        self.ovws("replay", self.recording, "--frames", f"12:{frames}", "-o", "ranges")
        self.assertIn("missing positions: 10:12", self.ovws("merge", *(self.folder / "ranges").glob("*.jsonl"), "-o", "x", status=1))
        part = self.folder / "older.jsonl"
        part.write_text(re.sub('"version":"[^"]*"', '"version":"0.0.1"', (self.folder / "replayed-parts" / "part-1-of-1.jsonl").read_text()))
        self.assertIn("older.jsonl was made by version 0.0.1", self.ovws("merge", part, "-o", "x", status=1))
        self.assertIn("real time", self.ovws("study", "rejection", "--shard", "1/2", "-o", "x", status=1))
        self.assertIn("i/N", self.ovws("study", "range", "--shard", "3/2", "-o", "x", status=2))
        wrong = ("--refine", "--black-level", "210", "--saturation", "200")
        self.assertIn("black_level_dn must be below saturation_dn", self.ovws("replay", self.recording, *wrong, status=1))
        self.assertFalse((self.folder / "x").exists())

    def snakemake(self, run, profile, shards, *more, env=None):
        """Starts a workflow with as many parts each of the study and the replay, in a process group of its own."""
        config = [f"recording={self.recording}", "replay_options=--refine", f"study={STUDY[0]}", f"study_options={STUDY[1]}", f"shards={shards}"]
        with open(self.folder / "snakemake.log", "ab") as log:
            return subprocess.Popen([SNAKEMAKE, "-s", CLUSTER / "Snakefile", "--profile", CLUSTER / "profiles" / profile, "-d", run, *more,
                                     *(["--cores", "2"] if profile == "local" else []),
                                     "--config", *config], env=env or self.env, stdout=log, stderr=log, start_new_session=True)

    def complete(self, *arguments, **options):
        process = self.snakemake(*arguments, **options)
        self.addCleanup(process.kill)
        self.assertEqual(process.wait(PROGRAM_PATIENCE_S), 0, (self.folder / "snakemake.log").read_text()[-3000:])

    def assert_results(self, run, shards):
        study, replay = self.whole()
        self.assertEqual(contents(run / STUDY[0]), study)
        self.assertEqual(contents(run / "replay"), replay)
        facts = json.loads((run / "replay" / "provenance.json").read_text())
        self.assertEqual(sorted(part["part"] for part in facts["parts"]), [f"part-{number}-of-{shards}.jsonl" for number in range(1, shards + 1)])
        self.assertTrue(all(part["host"] and "--shard" in part["command"] for part in facts["parts"]), facts)

    @unittest.skipIf(SNAKEMAKE is None, "apt-get install snakemake")
    def test_a_workflow_that_was_killed_ends_with_the_same(self):
        run = self.folder / "killed"
        first = self.snakemake(run, "local", 7)
        wait_for(lambda: len(list(run.glob("*/parts/part-*.jsonl"))) >= 4, what="some parts")
        os.killpg(first.pid, signal.SIGKILL)  # Snakemake and what it started
        first.wait()
        finished = {path: path.stat().st_mtime_ns for path in run.glob("*/parts/part-*.jsonl")}
        print(f"\n  killed with {len(finished)} of 14 parts")
        self.assertLess(len(finished), 14)
        self.assertFalse(list(run.glob("*/summary.json")))
        self.complete(run, "local", 7, "--unlock")
        self.complete(run, "local", 7)
        self.assert_results(run, 7)
        kept = [path for path, made in finished.items() if path.stat().st_mtime_ns == made]
        self.assertGreaterEqual(len(kept), len(finished) - 2, "finished parts are computed once")
        self.assertEqual(list(run.glob("*/parts/.*.tmp")), [])

    @unittest.skipIf(SNAKEMAKE is None, "apt-get install snakemake")
    @unittest.skipIf(slurm.missing(), "apt-get install --no-install-recommends slurmctld slurmd slurm-client munge")
    @unittest.skipIf(os.geteuid() != 0, "Slurm's programs need root")
    def test_a_slurm_cluster(self):
        cluster = slurm.Slurm(self.folder / "slurm")
        self.addCleanup(cluster.close)
        run, env = self.folder / "on-slurm", self.env | {"SLURM_CONF": cluster.env["SLURM_CONF"]}
        cluster.run("scontrol", "update", "partitionname=all", "state=down")  # so that jobs wait
        workflow = self.snakemake(run, "slurm", 2, env=env)
        self.addCleanup(workflow.kill)
        first = wait_for(lambda: len(jobs := cluster.run("squeue", "--noheader", "--format=%i").split()) == 4 and jobs, what="a job for each part")
        cluster.run("scancel", first[0])
        wait_for(lambda: set(cluster.run("squeue", "--noheader", "--format=%i").split()) - set(first), what="the lost job again")
        cluster.run("scontrol", "update", "partitionname=all", "state=up")
        self.assertEqual(workflow.wait(PROGRAM_PATIENCE_S), 0, (self.folder / "snakemake.log").read_text()[-3000:])
        self.assert_results(run, 2)

    def test_the_commands_of_the_guide(self):
        (text,) = re.findall(r"^```bash\n(.*?)^```$", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
        commands = textwrap.dedent(text).splitlines()
        self.assertGreaterEqual(len(commands), 5)
        for command in commands:
            if command.split()[0] in ("parallel", "snakemake") and shutil.which(command.split()[0], path="/usr/bin") is None:
                print("\n  skipped:", command)
                continue
            done = subprocess.run(["bash", "-c", command.replace("config/cluster", str(CLUSTER))], cwd=self.folder, env=self.env,
                                  capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
            self.assertEqual(done.returncode, 0, command + "\n" + done.stdout + done.stderr)


if __name__ == "__main__":
    main()

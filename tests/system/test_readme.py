"""The commands and the code that the README shows are run as they stand there."""
import re
import shlex
import subprocess
import sys
import textwrap

from case import ROOT, BenchCase, main

TEXT = (ROOT / "README.md").read_text()


def blocks(language):
    found = re.findall(rf"^( *)```{language}\n(.*?)^\1```$", TEXT, re.MULTILINE | re.DOTALL)
    return [textwrap.dedent(block) for _, block in found]


class Readme(BenchCase):
    daemon_config = {"state": {"directory": "state"}}

    def run_here(self, command):
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=self.bench.directory)
        print("\n  $", shlex.join(map(str, command))[:100])
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_commands_for_a_running_daemon(self):
        commands = [shlex.split(line) for block in blocks("sh") for line in block.splitlines() if re.search(r"(^|/bin/)ovws ", line)]
        (self.bench.directory / "build").mkdir()  # there in a clone that was built
        self.assertGreaterEqual(len(commands), 9)
        for program, *arguments in commands:
            if arguments[0] == "watch":
                arguments += ["-n", "1"]  # it would go on for ever
            self.assertTrue(self.run_here([self.bench.programs / program.rsplit("/", 1)[-1], *arguments]))
            self.wait_until("running")  # a reference takes its time
        self.assertTrue((self.bench.directory / "build" / "coma-camera.png").exists())

    def test_the_code_for_numbers(self):
        self.take_reference(20)
        (code,) = blocks("python")
        printed = self.run_here([sys.executable, "-c", code])
        self.assertEqual(len(eval(printed, {"__builtins__": {}})), 18)  # a list of numbers, as printed

    def test_the_two_commands_and_what_installs_exist(self):
        for name in re.findall(r"(?:daemon|tests)/(?:demo|run|setup)", TEXT):
            self.assertTrue((ROOT / name).stat().st_mode & 0o100, name)
        for link in re.findall(r"\]\(([^)#:]+)\)", TEXT):
            self.assertTrue((ROOT / link).exists(), link)

    def test_the_documents_about_faults_and_accuracy_name_what_exists(self):
        faults, accuracy = ((ROOT / "daemon/guide" / name).read_text() for name in ("faults.md", "accuracy.md"))
        named = re.findall(r"`system_(\w+)`", faults)
        self.assertGreater(len(named), 15)
        for name in named:
            self.assertTrue((ROOT / "tests" / "system" / f"test_{name}.py").exists(), name)
        told = self.run_here([self.bench.programs / "ovws", "study", "--help"])
        for name in re.findall(r"`ovws study (\w+)`", accuracy):
            self.assertIn(name, told)


if __name__ == "__main__":
    main()

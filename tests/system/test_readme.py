"""Runs the commands and code shown in README.md and the guides; checks that all their links resolve."""
import re
import shlex
import subprocess
import sys
import textwrap
import unittest

from case import PROGRAM_PATIENCE_S, ROOT, BenchCase, main

# The commands build on each other in this order, as on a bench.
GUIDES = [f"daemon/guide/{name}.md" for name in ("lattices", "optics", "refined", "live-page", "images", "command-line", "setup", "check", "bench")]
PAGES = ["README.md", *(str(path.relative_to(ROOT)) for path in sorted((ROOT / "daemon/guide").glob("*.md")))]


def blocks(language, *pages):
    found = [block for page in pages for block in re.findall(rf"^( *)```{language}\n(.*?)^\1```$", (ROOT / page).read_text(), re.MULTILINE | re.DOTALL)]
    return [textwrap.dedent(block) for _, block in found]


def commands_of(*pages):
    """All `ovws` commands in the shell blocks of these pages, in order."""
    return [shlex.split(line) for block in blocks("sh", *pages) for line in block.splitlines() if re.search(r"(^|/bin/)ovws ", line)]


def anchors(page):
    """The link anchors of the page's headings."""
    text = re.sub(r"^( *)```.*?^\1```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    headings = (re.sub(r"[^\w\- ]", "", heading).lower() for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE))
    return {heading.replace(" ", "-") for heading in headings}


class Documents(unittest.TestCase):
    def test_every_guide_with_commands_is_run(self):
        self.assertEqual({page for page in PAGES if commands_of(page)} - {"README.md"}, {page for page in GUIDES if commands_of(page)})

    def test_the_two_commands_and_what_installs_exist(self):
        named = {name for page in PAGES for name in re.findall(r"\b(?:daemon|tests)/(?:demo|run|setup|package|soak|bench/\w+)\b", (ROOT / page).read_text())}
        self.assertGreaterEqual(named, {"daemon/demo", "daemon/setup", "tests/run"})
        for name in named:
            self.assertTrue((ROOT / name).stat().st_mode & 0o100, name)

    def test_the_links_resolve(self):
        for page in map(ROOT.joinpath, PAGES):
            text = page.read_text()
            found = re.findall(r"\]\(([^)#:]*)(?:#([^):]*))?\)", text) + [(name, "") for name in re.findall(r'<img src="([^"]+)"', text)]
            for link, anchor in found:
                with self.subTest(page=page.name, link=link, anchor=anchor):
                    target = page.parent / link if link else page
                    self.assertTrue(target.exists())
                    if anchor:
                        self.assertIn(anchor, anchors(target))

    def test_the_readme_stays_short(self):
        self.assertLessEqual(len((ROOT / "README.md").read_text().splitlines()), 180)


class Readme(BenchCase):
    small = True
    daemon_config = {"state": {"directory": "state"}}

    def run_here(self, command):
        done = subprocess.run(command, capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, cwd=self.bench.directory)
        print("\n  $", shlex.join(map(str, command))[:100])
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_commands_for_a_running_daemon(self):
        commands = commands_of("README.md", *GUIDES)
        (self.bench.directory / "build").mkdir()  # exists in a built clone
        self.assertGreaterEqual(len(commands), 9)
        for _, *arguments in commands:
            if arguments[0] == "watch":
                arguments += ["-n", "1"]  # it would run forever
            self.assertTrue(self.run_here(self.ovws_command(*arguments)))
            self.wait_until("running")  # wait for jobs, such as the reference
        self.assertTrue((self.bench.directory / "build" / "coma-camera.png").exists())

    def test_the_code_for_numbers(self):
        self.take_reference(20)
        (code,) = blocks("python", "README.md")
        printed = self.run_here([sys.executable, "-c", code])
        self.assertEqual(len(eval(printed, {"__builtins__": {}})), 18)  # a list of numbers, as printed

    def test_the_documents_about_faults_and_accuracy_name_what_exists(self):
        faults, accuracy = ((ROOT / "daemon/guide" / name).read_text() for name in ("faults.md", "accuracy.md"))
        named = re.findall(r"`system_(\w+)`", faults)
        self.assertGreater(len(named), 15)
        for name in named:
            self.assertTrue((ROOT / "tests" / "system" / f"test_{name}.py").exists(), name)
        printed = self.run_here([self.bench.programs / "ovws", "study", "--help"])
        for name in re.findall(r"`ovws study (\w+)`", accuracy):
            self.assertIn(name, printed)


if __name__ == "__main__":
    main()

"""Manual pages and completions are complete, agree with --help, and pass strict lint tools."""
import functools
import json
import os
import pathlib
import re
import subprocess
import unittest

from case import PROGRAM_PATIENCE_S, bench_module, wait_for
from terminal import Terminal

BUILD = pathlib.Path(os.environ.get("OVWS_BUILD", ""))
MADE = BUILD / "daemon" / "ovws" / "man"
PAGES = ("ovws.1", "ovws-twin.1", "ovwsd.8", "ovwsd.json.5")


def run(*command, **more):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, **more)
    assert done.returncode == 0, done.stderr
    return done


@functools.cache
def help_of(program, *command):
    return run(bench_module.find_programs() / program, *command, "--help").stdout


def options_in(help_text):
    return set(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", "\n".join(re.findall(r"^  (-\S+)", help_text, re.MULTILINE))))


def commands():
    return re.findall(r"^  ([a-z]+) ", help_of("ovws").split("Subcommands:")[1], re.MULTILINE)


def schemas_with_params():
    texts = {path.stem: json.loads(path.read_text()) for path in (BUILD / "schema").glob("*.json")}
    return {name: schema["params"].get("properties", {}) for name, schema in texts.items() if "params" in schema}


class Pages(unittest.TestCase):
    def read(self, page):
        return re.sub(r"\s+", " ", run("man", "-l", MADE / page, env=os.environ | {"MANWIDTH": "5000", "LC_ALL": "C.UTF-8"}).stdout)

    def test_strict_readers_are_silent(self):
        for page in PAGES:
            with self.subTest(page):
                lint = subprocess.run(["mandoc", "-Tlint", MADE / page], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
                self.assertEqual((lint.returncode, lint.stdout + lint.stderr), (0, ""))
                self.assertEqual(run("groff", "-man", "-ww", "-Tutf8", "-z", MADE / page).stderr, "")
                shown = run("man", "--warnings", "-l", MADE / page, env=os.environ | {"MANWIDTH": "80", "LC_ALL": "C.UTF-8"})
                self.assertEqual(shown.stderr, "")

    def test_every_command_and_option_is_there(self):
        text = self.read("ovws.1")
        self.assertGreaterEqual(len(commands()), 12)
        for command in commands():
            self.assertIn(f"ovws {command} ", text)
            for option in options_in(help_of("ovws", command)) - {"-h", "--help"}:
                self.assertRegex(text, rf"(?<![\w-]){option}[ ,]")
        self.assertIn("3 no daemon answered in time", text)
        for said in ("EXIT STATUS", "2 the command line is wrong", "/var/lib/ovws/config.json"):
            self.assertIn(said, self.read("ovwsd.8"))
        for program, page in (("ovwsd", "ovwsd.8"), ("ovws-twin", "ovws-twin.1")):
            for option in options_in(help_of(program)):
                self.assertRegex(self.read(page), rf"(?<![\w-]){option}[ ,]")

    def test_every_key_of_the_configuration_is_there(self):
        text = self.read("ovwsd.json.5")
        done = run(bench_module.find_programs() / "ovwsd", "--check-config", env=os.environ | {"DISPLAY": ""})
        keys = set(re.findall(r'"(\w+)":', done.stdout)) - {"roi"}
        self.assertGreater(len(keys), 40)
        for key in keys:
            self.assertRegex(text, rf"\b{key}\b")
        for said in ("0 to 10 000", "µs", "λ/d", "did you mean"):
            self.assertIn(said, text)


class Completions(unittest.TestCase):
    def completed(self, *words):
        """Bash's completions of the last of these words."""
        script = f'source {MADE / "completion.bash"}; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _ovws; printf "%s\\n" "${{COMPREPLY[@]}}"'
        return set(run("bash", "--norc", "-c", script, "bash", *words).stdout.splitlines()) - {""}

    def test_the_file_is_what_the_program_prints(self):
        program, text = bench_module.find_programs() / "ovws", (MADE / "completion.bash").read_text()
        for length in range(8, 96, 4):  # of the program's name, which decides what freed memory would hold
            self.assertEqual(text, run("x" * length, "completion", "bash", executable=program).stdout)

    def test_every_command_option_and_choice(self):
        self.assertEqual(self.completed("ovws", ""), set(commands()))
        common = options_in(help_of("ovws"))
        for command in commands():
            with self.subTest(command):
                text = help_of("ovws", command)
                self.assertEqual(self.completed("ovws", command, "-"), options_in(text) | common)
                for option, choices in re.findall(r"^  (?:-\w,)?(--[a-z-]+) TEXT:\{(.*?)\}", text, re.MULTILINE):
                    self.assertEqual(self.completed("ovws", command, option, ""), set(choices.split(",")))
                for choices in re.findall(r"^  [a-z]+ TEXT:\{(.*?)\}", text, re.MULTILINE):
                    self.assertEqual(self.completed("ovws", command, ""), set(choices.split(",")))

    def test_every_method_its_keys_and_their_values(self):
        methods = schemas_with_params()
        self.assertGreater(len(methods), 40)
        self.assertEqual(self.completed("ovws", "call", ""), set(methods))
        self.assertEqual(self.completed("ovws", "describe", ""), set(methods))
        self.assertEqual(self.completed("ovws", "aberrate", "def"), {"defocus="})
        self.assertEqual(self.completed("ovws", "loop", "close", "law", "=", "p"), {"predictor"})
        for method, keys in methods.items():
            found = {word.rstrip("=.").split(".")[0] for word in self.completed("ovws", "call", method, "")}
            self.assertEqual(found, set(keys), method)
        self.assertEqual(self.completed("ovws", "call", "camera.set", "ro"), {f"roi.{key}=" for key in ("x", "y", "width", "height")})
        self.assertEqual(self.completed("ovws", "call", "sensor.set", "tracker", "="), set(methods["sensor.set"]["tracker"]["enum"]))
        self.assertEqual(self.completed("ovws", "call", "camera.set", "gain_db", "=", "3", "clamp", "=", "t"), {"true"})
        self.assertEqual(self.completed("ovws", "call", "aberration.set", "modes.def"), {"modes.defocus="})
        self.assertIn("modes.vertical-coma=", self.completed("ovws", "call", "aberration.set", "modes."))

    def test_words_before_do_not_confuse_it(self):
        self.assertEqual(self.completed("ovws", "--endpoint", "tcp", ":", "//127.0.0.1", ":", "7702", "call", "-w", "sensor.s"), {"sensor.set"})
        self.assertEqual(self.completed("ovws", "--timeout", "3", "--json", "sta"), {"status"})
        self.assertEqual(self.completed("ovws", "measure", "--tracker", "=", "wei"), {"weighted"})
        self.assertEqual(self.completed("ovws", "no-such-command", ""), set())

    def test_at_a_prompt(self):
        shell = Terminal(["bash", "--norc", "-i"], columns=100, PS1="$ ", INPUTRC="/dev/null")
        self.addCleanup(shell.close)
        shell.press(f"source {MADE / 'completion.bash'}; clear\n")
        for keys, line in (("ovws wa\t--pl\t", "ovws watch --plain"), ("ovws call sensor.se\t", "ovws call sensor.set"),
                           ("ovws call sensor.set track\twei\t", "ovws call sensor.set tracker=weighted"),
                           ("ovws call camera.set \tgain_d\t12 cl\ttr\t", "ovws call camera.set gain_db=12 clamp=true")):
            with self.subTest(line):
                shell.press("\x15\x0c" + keys)
                wait_on(lambda: any(row.rstrip() == "$ " + line for row in shell.rows()), shell)
        shell.press("\x15exit\n")


def wait_on(condition, shell):
    """Like wait_for; on failure shows the terminal's content."""
    try:
        wait_for(condition)
    except AssertionError:
        raise AssertionError(shell.text().rstrip()) from None


if __name__ == "__main__":
    unittest.main(verbosity=2)

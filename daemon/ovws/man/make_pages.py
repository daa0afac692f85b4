#!/usr/bin/python3
"""Generates the manual pages from the programs' --help and from config/README.md.

    daemon/ovws/man/make_pages.py FOLDER_OF_PROGRAMS OUTPUT_FOLDER
"""
import itertools
import os
import re
import subprocess
import sys
import time
from pathlib import Path

from roff import Page, of_markdown

ROOT = Path(__file__).resolve().parents[3]
SEE = {"ovws": (1, "command line of the optical vortex wavefront sensor"),
       "ovws-twin": (1, "digital twin of the optical vortex wavefront sensor's bench"),
       "ovwsd": (8, "real-time daemon of the optical vortex wavefront sensor"),
       "ovwsd.json": (5, "configuration of the optical vortex wavefront sensor's daemon")}


class Help:
    """Parsed --help output: description, usage, the entries of each section (options, positionals, subcommands), and the footer."""

    def __init__(self, program, *command):
        done = subprocess.run([program, *command, "--help"], capture_output=True, text=True, check=True)
        head, *rest = re.split(r"\n\n(?=\w+:\n)", done.stdout.strip())
        self.about, _, usage = head.partition("\nUsage: ")
        self.usage = usage.replace(str(program), program.name)
        self.footer = ""
        if rest and "\n\n" in rest[-1]:
            rest[-1], self.footer = rest[-1].split("\n\n", 1)
        self.sections = {part.split(":\n", 1)[0]: self.entries(part.split(":\n", 1)[1]) for part in rest}

    @staticmethod
    def entries(text):
        """[(name, lines of description)]: names are indented by 2 columns, descriptions by 30, on the same line if the name is short."""
        found, lines = [], text.splitlines()
        for line, following in zip(lines, lines[1:] + [""]):
            if not re.match(r"  \S", line):
                found[-1][1].append(line.strip())
            elif line[28:30] == "  " or (line[29:30] == " " and not following.startswith(30 * " ")):
                found.append((line[:30].strip(), [line[30:].strip()]))
            else:
                found.append((line.strip(), []))
        return found


def kind_of(text):
    """Makes CLI11's type and constraint text after an option's name readable."""
    text = re.sub(r"^[A-Z]+:\{(.*?)\}", lambda found: "one of " + found[1].replace(",", ", "), text)
    text = re.sub(r"^(\w+):\1 in \[(\S+) - (\S+)\]", r"\1 from \2 to \3", text)
    text = re.sub(r"=(\S+)", r", default \1", text)
    text = re.sub(r" REQUIRED", ", required", text)
    text = re.sub(r" \(Env:(\w+)\)", r", or $\1", text)
    return re.sub(r" Excludes: ", ", not with ", re.sub(r" Needs: ", ", with ", text))


def put_entries(page, entries):
    for name, words in entries:
        names, _, kind = name.partition(" ")
        page.tagged([("b", names.replace(",", ", ")), ("r", " " + kind_of(kind) if kind else "")])
        for word in words:
            page.text(word)
            page.line_break()


def sentence(text):
    return text[:1].upper() + text[1:] + "."


def put_end(page, name, footer=""):
    if footer:
        page.section("Exit status")
        page.text(footer.replace("Exit codes: ", "").replace("\n", " "))
    page.section("See also")
    others = [f"{other}({number})" for other, (number, _) in SEE.items() if other != name]
    page.text(", ".join(others) + ".")
    page.text("README.md and proto/WIRE.md in the folder of the package's documentation.")


def put_footer(page, footer):
    """The text after a command's options: indented lines are code."""
    for is_code, lines in itertools.groupby(footer.splitlines(), key=lambda line: line.startswith("  ")):
        if is_code:
            page.code([line.strip() for line in lines])
        else:
            page.paragraph()
            page.text(" ".join(lines))


def new_page(name, version):
    number, about = SEE[name]
    page = Page(name, number, version, time.strftime("%Y-%m-%d", time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())))))
    page.section("Name")
    page.raw(f"{name} \\- {about}")
    return page


def program_page(name, programs, version, describe, environment, files=()):
    """Builds a program's page. `describe` adds the text between synopsis and options."""
    help_ = Help(programs / name)
    page = new_page(name, version)
    page.section("Synopsis")
    page.tagged_line([("b", name), ("r", " " + help_.usage.split(" ", 1)[1])])
    page.section("Description")
    page.text(sentence(help_.about))
    describe(page, help_)
    page.section("Options")
    put_entries(page, help_.sections["Options"])
    page.section("Environment")
    for variable, words in environment:
        page.tagged([("b", variable)])
        page.text(words)
    if files:
        page.section("Files")
        for file, words in files:
            page.tagged([("i", file)])
            page.text(words)
    put_end(page, name, help_.footer)
    return page


def ovws_page(programs, version):
    def describe(page, help_):
        page.text("The options below can precede or follow the command.")
        page.section("Commands")
        for command, _ in help_.sections["Subcommands"]:
            own = Help(programs / "ovws", command)
            page.subsection(f"{own.usage}".replace("[OPTIONS]", "[options]"))
            page.text(sentence(own.about))
            put_entries(page, own.sections.get("Positionals", []) + [e for e in own.sections["Options"] if "--help" not in e[0]])
            put_footer(page, own.footer)

    return program_page("ovws", programs, version, describe, [
        ("OVWS_KEY", "same as --key"), ("OVWS_SERVER_KEY", "same as --server-key"), ("OVWS_METRICS_LISTEN", "same as --listen of metrics"),
        ("NO_COLOR", "if not empty, the screen of watch has no colours"),
        ("TERM", "if \"dumb\" or unset, watch prints a table")])


def ovwsd_page(programs, version):
    def describe(page, _):
        page.text("It shows the sensor's hologram on the SLM, tracks one spot per subaperture in every camera frame, reconstructs Zernike "
                  "coefficients and publishes them over ZeroMQ. Commands are JSON-RPC; ovws(1) is a client. SIGHUP reloads the configuration; "
                  "SIGTERM and SIGINT stop the daemon.")

    return program_page("ovwsd", programs, version, describe, [
        ("STATE_DIRECTORY", "set by systemd: the folder for state that survives a restart, unless the configuration names one"),
        ("DISPLAY, XAUTHORITY", "the X server of the SLM"), ("NOTIFY_SOCKET, WATCHDOG_USEC", "set by systemd")], [
        ("/etc/ovws/ovwsd.json", "the service's configuration, ovwsd.json(5); ovwsd reads it only if --config names it, as the service's unit does"),
        ("/var/lib/ovws", "the service's state directory: references, calibrations, the registration, measurements of the SLM"),
        ("/var/lib/ovws/config.json", "the overlay of settings saved by config.save, which take precedence over the configuration"),
        ("/var/lib/ovws/config.json.rejected", "an unusable overlay that was set aside"),
        ("/var/lib/ovws/recordings", "recordings of record.start, readable by members of the group ovws-data"),
        ("/var/lib/ovws/xauthority", "the cookie of the SLM's X server")])


def twin_page(programs, version):
    def describe(page, _):
        page.text("It reads the SLM's output of an X server, computes the camera image, and acts as a GigE Vision camera. When it is ready, it "
                  "prints a line that begins with \"ready\". SIGTERM and SIGINT stop it. drivers/twin/README.md describes its keys and faults.")

    return program_page("ovws-twin", programs, version, describe, [("DISPLAY", "the X server, unless --display is given")])


def config_page(version):
    page = new_page("ovwsd.json", version)
    page.section("Description")
    of_markdown(page, (ROOT / "config" / "README.md").read_text())
    put_end(page, "ovwsd.json")
    return page


def main():
    programs, out = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    version = subprocess.run([programs / "ovws", "--version"], capture_output=True, text=True, check=True).stdout.strip()
    out.mkdir(parents=True, exist_ok=True)
    for page in (ovws_page(programs, version), ovwsd_page(programs, version), twin_page(programs, version), config_page(version)):
        (out / f"{page.name}.{page.number}").write_text(page.whole())


if __name__ == "__main__":
    main()

"""Answers the questions of `ovws setup` on a terminal."""
import re
import time

from case import PROGRAM_PATIENCE_S

QUESTION = re.compile(rb"^(?:\r\x1b\[K)*> (.*)\? help\r?$", re.M)  # on a terminal wide enough not to wrap it
PICTURE = re.compile(r"[ .:\-=+*#%@]{40,}")


def on(question):
    """The answer that goes on: Enter, and q where Enter would only repeat what has failed."""
    return "q" if question.startswith("Enter repeats") else "\n"


def talk(terminal, answer=on, timeout_s=PROGRAM_PATIENCE_S):
    """Gives `answer(question)` to each question until the program ends; the next question, or the end, takes at most `timeout_s`. Returns its exit status."""
    answered, end = 0, time.monotonic() + timeout_s
    while terminal.process.poll() is None:
        questions = QUESTION.findall(terminal.raw)
        if len(questions) > answered:
            terminal.press(answer(questions[answered].decode()))
            answered, end = answered + 1, time.monotonic() + timeout_s
        elif time.monotonic() > end:
            raise AssertionError(f"ovws setup neither asked nor ended within {timeout_s:.0f} s:\n{transcript(terminal)[-3000:]}")
        else:
            time.sleep(0.05)
    return terminal.wait()


def transcript(terminal):
    """What was printed, without progress lines and pictures."""
    lines = terminal.raw.decode(errors="replace").replace("\x1b[K", "").replace("\0", "").replace("\r\n", "\n").split("\n")
    return "\n".join(line for line in (line.rsplit("\r", 1)[-1] for line in lines) if not PICTURE.fullmatch(line))

"""Writes manual pages in man(7) format, and converts the Markdown of this project's documents to it."""
import re
import textwrap

WIDTH = 78
FONTS = {"b": "\\fB", "i": "\\fI", "r": ""}
SIGNS = {"µ": "\\(mc", "·": "\\(pc", "π": "\\(*p", "λ": "\\(*l", "±": "\\(+-", "…": "...", "→": "\\(->", "²": "\\(S2", "°": "\\(de", "×": "\\(mu"}


def escaped(text):
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga").replace("^", "\\(ha").replace("~", "\\(ti")
    text = "".join(SIGNS.get(sign, sign) for sign in text)
    return re.sub(r"[^\x00-\x7f]", lambda found: f"\\[u{ord(found[0]):04X}]", text)


class Page:
    """Lines of roff. Methods take plain text and escape roff's special characters."""

    def __init__(self, name, number, version, date):
        self.name, self.number = name, number
        self._lines = [f'.TH "{name.upper()}" "{number}" "{date}" "ovws {version}" ""', ".nh", ".ad l"]

    def raw(self, line):
        # A line of text must not look like a request.
        self._lines.append(("\\&" if line[:1] in ".'" else "") + line)

    def section(self, title):
        self._lines.append(f'.SH "{escaped(title.upper())}"')

    def subsection(self, title):
        self._lines.append(f'.SS "{escaped(title)}"')

    def paragraph(self):
        if not self._lines[-1].startswith((".SH", ".SS", ".PP", ".TP", ".IP")):
            self._lines.append(".PP")

    def line_break(self):
        self._lines.append(".br")

    def text(self, text, font="r"):
        self.spans([(font, text)])

    def spans(self, spans):
        """Adds [(font, text)] as wrapped lines."""
        whole = "".join(FONTS[font] + escaped(text) + ("\\fR" if FONTS[font] else "") for font, text in spans)
        for line in textwrap.wrap(re.sub(r"\s+", " ", whole).strip(), WIDTH, break_long_words=False, break_on_hyphens=False):
            self.raw(line)

    def tagged(self, spans):
        """Begins a tagged paragraph (.TP) with this tag."""
        self._lines.append(".TP")
        self.tagged_line(spans)

    def tagged_line(self, spans):
        self.raw("".join(FONTS[font] + escaped(text) + ("\\fR" if FONTS[font] else "") for font, text in spans))

    def code(self, lines):
        self._lines += [".PP", ".RS 4", ".nf"]
        for line in lines:
            self.raw(escaped(line))
        self._lines += [".fi", ".RE"]

    def whole(self):
        kept = []
        for number, line in enumerate(self._lines):
            follows = self._lines[number + 1] if number + 1 < len(self._lines) else ".SH"
            if line in (".br", ".PP") and re.match(r"\.(SH|SS|TP|PP|br|RS)", follows):
                continue
            kept.append(line)
        return "\n".join(kept) + "\n"


def spans_of(text):
    """Converts inline Markdown to [(font, text)]: code and emphasis become fonts, links their text."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    spans = []
    for part in re.split(r"(`[^`]*`|\*\*[^*]*\*\*|\*\w[^*]*\w\*)", text):
        if part.startswith("`"):
            spans.append(("b", part[1:-1]))
        elif part.startswith("**"):
            spans.append(("b", part[2:-2]))
        elif re.fullmatch(r"\*\w.*\w\*", part):
            spans.append(("i", part[1:-1]))
        elif part:
            spans.append(("r", part))
    return spans


def put_table(page, rows):
    """Writes a table as one tagged entry per row: first cell as tag, middle cells as "name: value", last cell as text."""
    cells = [[cell.strip() for cell in row.strip().strip("|").split("|")] for row in rows]
    head, body = cells[0], cells[2:]
    for row in body:
        middle = [f"{name}: {cell}" for name, cell in zip(head[1:-1], row[1:-1]) if cell]
        page.tagged(spans_of(row[0]))
        if middle:
            page.spans(spans_of("; ".join(middle) + "."))
            page.line_break()
        if row[-1]:
            page.spans(spans_of(row[-1]))


def put_block(page, lines):
    if lines[0].startswith("## "):
        page.section(lines[0][3:])
        lines = lines[1:]
    if not lines:
        return
    if lines[0].startswith("|"):
        put_table(page, lines)
    elif lines[0].startswith("    "):
        page.code([line[4:] for line in lines])
    else:
        items = re.split(r"\n(?=- )", "\n".join(lines))
        for item in items:
            page.paragraph()
            page.spans(spans_of(item))


def of_markdown(page, text):
    """Converts sections, paragraphs, lists, tables and code. Skips the title, because the page has its own."""
    blocks, fenced = [[]], False
    for line in text.splitlines()[1:]:
        if line.startswith("```"):
            fenced = not fenced
            blocks.append([])
        elif fenced:
            blocks[-1].append("    " + line)
        elif not line.strip() or (line.startswith("|") and blocks[-1] and not blocks[-1][-1].startswith("|")):
            blocks.append([line] if line.strip() else [])
        else:
            blocks[-1].append(line)
    for block in blocks:
        if block:
            put_block(page, block)

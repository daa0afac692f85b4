#!/usr/bin/python3
"""Executes the cells of a notebook in order, as Jupyter would, without a kernel: run_notebook.py NOTEBOOK

What a cell shows goes to standard output: what it prints, and the HTML or the text of its last expression. At the end comes one line of JSON
with the notebook's numbers and texts by name. Without matplotlib, its calls do nothing; without IPython, `display` shows its values in the same way.
"""
import ast
import contextlib
import json
import numbers
import sys
import types
from pathlib import Path
from unittest import mock


def stand_in_for_matplotlib():
    with contextlib.suppress(ImportError):
        import matplotlib  # noqa: F401
        return
    sys.modules["matplotlib"] = sys.modules["matplotlib.pyplot"] = mock.MagicMock()
    sys.modules["matplotlib"].pyplot = sys.modules["matplotlib.pyplot"]


def show(value):
    if value is not None:
        print(value._repr_html_() if hasattr(value, "_repr_html_") else repr(value))


class Handle:
    """What IPython's display returns."""

    update = staticmethod(show)


def stand_in_for_ipython():
    with contextlib.suppress(ImportError):
        import IPython.display  # noqa: F401
        return
    shell, module = types.ModuleType("IPython"), types.ModuleType("IPython.display")
    shell.get_ipython = lambda: None  # as in a plain Python, for matplotlib
    module.display = lambda value, display_id=False: show(value) or Handle()
    sys.modules |= {"IPython": shell, "IPython.display": module}


def run(source, names, where):
    tree = ast.parse(source, where)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, where, "exec"), names)
    if last is not None:
        show(eval(compile(ast.Expression(last.value), where, "eval"), names))


def plain(value):
    """Whether a value says something about the notebook's result."""
    return isinstance(value, (numbers.Real, str)) or (isinstance(value, dict) and all(map(plain, value.values())))


def main():
    stand_in_for_matplotlib()
    stand_in_for_ipython()
    names = {"__name__": "__main__"}
    for number, cell in enumerate(json.loads(Path(sys.argv[1]).read_text())["cells"], 1):
        if cell["cell_type"] == "code":
            run("".join(cell["source"]), names, f"cell {number}")
    means = {name: {str(j): waves for j, waves in zip(value.j.tolist(), value.coefficients_waves.tolist())} for name, value in names.items()
             if type(value).__name__ == "MeanWavefront"}
    print(json.dumps({name: value for name, value in names.items() if not name.startswith("_") and plain(value)} | means, default=float))


if __name__ == "__main__":
    main()

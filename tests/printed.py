"""Code of a page, run statement by statement: ``# prints: ...`` is compared with what a statement prints."""

import ast
import contextlib
import doctest
import io
import re

_PRINTS = re.compile(r"^.*?# prints: (.*)$")
# "..." stands for the rest of a line
_OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def run_code(code, file, names):
    """Run the code of a page in ``names``; return the comments that differ from what was printed.

    A comment ``# prints: TEXT`` in a statement, or on the lines that follow it, is one printed line. A statement
    with such comments prints exactly their lines, those without print what they like.
    """
    lines = code.splitlines()
    statements = ast.parse(code).body
    ends = [s.lineno - 1 for s in statements[1:]] + [len(lines)]
    faults = []
    for statement, end in zip(statements, ends, strict=True):
        comments = map(_PRINTS.match, lines[statement.lineno - 1 : end])
        expected = "".join(f"{comment[1]}\n" for comment in comments if comment)
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            exec(compile(ast.Module([statement], []), str(file), "exec"), names)
        if expected and not doctest.OutputChecker().check_output(
            expected, output.getvalue(), _OPTIONS
        ):
            faults.append(f"{lines[statement.lineno - 1]}\n{output.getvalue()}")
    return faults

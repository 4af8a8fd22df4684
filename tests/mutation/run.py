"""Mutation run: change one operator or constant at a time and see whether its own tests notice.

    python tests/mutation/run.py                       the seeded sample of 300
    python tests/mutation/run.py --count 1000 --only axes/        of 1000, those in axes/

Needs ``pip install cosmic-ray``, whose operators it uses. A copy of the tree is mutated, never the
tree itself. Every process is forked from one that has already imported the libraries, so that a
mutant costs little more than its tests. Survivors are compared with ``survivors.txt``, where each
has the reason why it changes nothing; the exit code is 1 if one has none, or if fewer than 92 %
were killed.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import hashlib
import math
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter, defaultdict
from importlib import import_module
from pathlib import Path

os.environ.update(PYTHONDONTWRITEBYTECODE="1", OPENBLAS_NUM_THREADS="1", MPLBACKEND="Agg")

import parso.python.tree
from cosmic_ray.ast import ast_nodes, get_ast, is_number
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path("src/pathsim_jsbsim_blocks")
WANTED = 0.92
WAITING = 20  # times the limit of processor time, after which a mutant is taken to wait for ever
# plugins are imported already, which pytest would warn of
PYTEST = ["-x", "-q", "--no-header", "--tb=no", "-p", "no:cacheprovider", "-p", "no:xdist"]
PYTEST += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
BROKEN = 99  # exit code where pytest itself fails

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).parent))
from own_tests import GROUPS, OWN_TESTS  # noqa: E402


class OnePercent(Operator):
    """Multiply a constant by 1.01: a wrong unit or factor that a loose tolerance hides."""

    def mutation_positions(self, node):
        if is_number(node) and "." in node.value and float(node.value):
            yield node.start_pos, node.end_pos

    def mutate(self, node, index):
        return parso.python.tree.Number(f" {float(node.value) * 1.01!r}", node.start_pos)

    @classmethod
    def examples(cls):
        return ()


# one change that a mistaken hand might make; nonsense such as a shift of floats dies at once
OPERATORS = {
    name: get_operator(f"core/{name}")()
    for name in (
        "ReplaceBinaryOperator_Add_Sub",
        "ReplaceBinaryOperator_Sub_Add",
        "ReplaceBinaryOperator_Mul_Div",
        "ReplaceBinaryOperator_Div_Mul",
        "ReplaceBinaryOperator_Mul_Add",
        "ReplaceBinaryOperator_Pow_Mul",
        "ReplaceBinaryOperator_FloorDiv_Div",
        "ReplaceBinaryOperator_Mod_Div",
        "ReplaceUnaryOperator_Delete_Not",
        "ReplaceUnaryOperator_Delete_USub",
        "ReplaceUnaryOperator_USub_UAdd",
        "ReplaceComparisonOperator_Lt_LtE",
        "ReplaceComparisonOperator_LtE_Lt",
        "ReplaceComparisonOperator_Gt_GtE",
        "ReplaceComparisonOperator_GtE_Gt",
        "ReplaceComparisonOperator_Lt_GtE",
        "ReplaceComparisonOperator_LtE_Gt",
        "ReplaceComparisonOperator_Gt_LtE",
        "ReplaceComparisonOperator_GtE_Lt",
        "ReplaceComparisonOperator_Eq_NotEq",
        "ReplaceComparisonOperator_NotEq_Eq",
        "ReplaceComparisonOperator_Is_IsNot",
        "ReplaceComparisonOperator_IsNot_Is",
        "ReplaceTrueWithFalse",
        "ReplaceFalseWithTrue",
        "ReplaceAndWithOr",
        "ReplaceOrWithAnd",
        "AddNot",
        "ExceptionReplacer",
        "ZeroIterationForLoop",
        "ReplaceBreakWithContinue",
        "ReplaceContinueWithBreak",
        "NumberReplacer",
    )
} | {"OnePercent": OnePercent()}


def own_tests(tree: Path, module: Path) -> list[str]:
    """Arguments for pytest: the tests of a module, by the longest key that its path ends with."""
    path = f"/{module.relative_to(PACKAGE).with_suffix('').as_posix()}"
    keys = [
        key
        for key in OWN_TESTS
        if path.endswith(f"/{key}") or (key.endswith("/") and f"/{key}" in path)
    ]
    names, _, only = OWN_TESTS[max(keys, key=len)].partition(" -k ") if keys else ("", "", "")
    found = []
    for name in names.split():
        paths = [
            p.relative_to(tree).as_posix()
            for p in sorted((tree / "tests").rglob(f"test_{name}.py"))
            if not {"browser", "mutation"} & {*p.parts}
        ]
        if not paths:
            raise SystemExit(f"no test file test_{name}.py, for {module}")
        found += paths
    return [*found, "-k", only] if only else found


def silent(source: str) -> list[tuple[int, int, int, int]]:
    """Spans that mutants are not made in: annotations, messages, logging, type checking."""
    spans = []

    def add(node):
        if node is not None:
            spans.append((node.lineno, node.col_offset, node.end_lineno, node.end_col_offset))

    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.AnnAssign):
            add(node.annotation)
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            add(node.returns)
        elif isinstance(node, ast.arg):
            add(node.annotation)
        elif isinstance(node, ast.JoinedStr):
            add(node)
        elif isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            for argument in node.exc.args[:1]:
                add(argument)
        elif (
            isinstance(node, ast.Call)
            and ast.unparse(node.func).startswith(("log.", "warnings.", "TypeVar"))
        ) or (isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)):
            add(node)
        elif isinstance(node, ast.Assign) and re.match(
            r"(tuple|dict|list|Callable|Sequence|Mapping)\[|\w+ \| ", ast.unparse(node.value)
        ):
            add(node.value)
    return spans


def mutants(source: str) -> dict[tuple[int, int], list[tuple[str, int]]]:
    """(operator, occurrence) of each mutant, by the place that it changes."""
    tree = get_ast(source)
    spans = silent(source)
    places = defaultdict(list)
    for name, operator in OPERATORS.items():
        positions = (
            position for node in ast_nodes(tree) for position in operator.mutation_positions(node)
        )
        for occurrence, ((line, column), _) in enumerate(positions):
            if not any((a, b) <= (line, column) < (c, d) for a, b, c, d in spans):
                places[line, column].append((name, occurrence))
    return places


def sample(tree: Path, only: str, count: int, seed: int) -> list[tuple[Path, str, int]]:
    """Seeded sample of (module, operator, occurrence) without two mutants at one place.

    Each group of modules has an equal share. Places are drawn by the hash of their text, so that a
    change elsewhere leaves the sample as it is.
    """
    drawn = defaultdict(list)
    for path in sorted((tree / PACKAGE).rglob("*.py")):
        module = path.relative_to(tree)
        if not own_tests(tree, module):
            continue
        source = path.read_text()
        lines, seen = source.splitlines(), Counter()
        for (line, column), choices in sorted(mutants(source).items()):
            text = f"{module.name} {lines[line - 1]} {column}"
            seen[text] += 1
            digest = hashlib.sha256(f"{seed} {text} {seen[text]}".encode()).digest()
            operator, occurrence = random.Random(digest).choice(choices)
            drawn[group(module)].append((digest, module, operator, occurrence))
    print(f"{sum(map(len, drawn.values()))} places for mutants", flush=True)
    ranked = sorted((i, row) for rows in drawn.values() for i, row in enumerate(sorted(rows)))
    return [mutant for _, (_, *mutant) in ranked[:count] if re.search(only, mutant[0].as_posix())]


def group(module: Path) -> str:
    """The folder of a module, or its part of a large one."""
    folder, name = module.relative_to(PACKAGE).parent.as_posix(), module.stem
    return GROUPS.get(f"{folder}/{name}", folder)


def changed(before: str, after: str) -> tuple[int, str, str]:
    """Line number of the first difference, and the line before and after."""
    old, new = before.splitlines(), after.splitlines()
    for i, (a, b) in enumerate(zip(old, new, strict=False)):
        if a != b:
            return i + 1, " ".join(a.split()), " ".join(b.split())
    return 0, "", ""


def run_tests(tree: Path, tests: list[str], limit: float) -> tuple[str, float, str]:
    """ "passed", "failed" or "timeout", seconds, and the test that failed.

    The limit is one of processor time, so that other work on the machine kills no mutant.
    """
    start = time.monotonic()
    report = tree / "report.txt"
    child = os.fork()
    if not child:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(limit), math.ceil(limit) + 5))
        fd = os.open(report, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(fd, 1)
        os.dup2(fd, 2)
        os.chdir(tree)
        os.environ["PYTHONPATH"] = str(tree / "src")
        sys.path[:] = [
            str(tree / "src"),
            *(p for p in sys.path if p not in (str(ROOT / "src"), str(Path(__file__).parent), "")),
        ]
        pytest = import_module("pytest")
        code = BROKEN
        try:
            code = pytest.main([*PYTEST, *tests])
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            os._exit(int(code))
    while True:
        pid, status = os.waitpid(child, os.WNOHANG)
        taken = time.monotonic() - start
        if pid:
            break
        if taken > WAITING * limit:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return "timeout", taken, ""
        time.sleep(0.02)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # what the tests have started and left
    text = report.read_text(errors="replace")
    code = os.waitstatus_to_exitcode(status)
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        return "timeout", taken, ""
    if code == BROKEN:  # pytest itself: it says nothing of a mutant
        raise SystemExit(text)
    lines = text.splitlines()
    failed = next((x.split(" - ")[0] for x in lines if x.startswith(("FAILED", "ERROR"))), "")
    if status == 0:
        return "passed", taken, ""
    return "failed", taken, failed or (lines[-1] if lines else f"status {status}")


def preload() -> None:
    """Import the libraries once, and leave the package itself out."""
    sys.path.insert(0, str(ROOT / "src"))
    for name in ("matplotlib.pyplot", "pytest", "scipy.signal", "pathsim_jsbsim_blocks"):
        import_module(name)
    for name in [name for name in sys.modules if name.startswith("pathsim_jsbsim_blocks")]:
        del sys.modules[name]
    hypothesis = import_module("hypothesis")
    hypothesis.settings.register_profile("mutation", derandomize=True, database=None)
    hypothesis.settings.load_profile("mutation")


def reasons() -> dict[str, str]:
    """Reasons by mutant (``module: line before -> line after``)."""
    known, mutant = {}, ""
    for line in (Path(__file__).parent / "survivors.txt").read_text().splitlines():
        if line.startswith("    "):
            known[mutant] = line.strip()
        elif line and not line.startswith("#"):
            mutant = line
    return known


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", default="", help="run those whose module fits this pattern")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--list", action="store_true", help="show the sample, run nothing")
    parser.add_argument("--journal", type=Path, help="go on from the outcomes kept in this file")
    options = parser.parse_args()
    kept = {}
    if options.journal and options.journal.exists():
        kept = dict(line.split() for line in options.journal.read_text().splitlines())
    known = reasons()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(
            ROOT,
            tree,
            ignore=shutil.ignore_patterns(
                ".git", ".venv*", "__pycache__", ".*_cache", ".hypothesis"
            ),
        )
        modules = [p.relative_to(tree / PACKAGE) for p in (tree / PACKAGE).rglob("*.py")]
        paths = "".join(f"/{p.with_suffix('').as_posix()}\n" for p in modules)
        if gone := [k for k in OWN_TESTS if f"/{k}" + "\n" * (k[-1] != "/") not in paths]:
            raise SystemExit(f"own_tests.py has modules that are gone: {', '.join(gone)}")
        chosen = sample(tree, options.only, options.count, options.seed)
        if not options.list:
            preload()
        killed, survivors, passed, baseline, unproven = 0, [], Counter(), {}, {}
        for i, (module, name, occurrence) in enumerate(chosen):
            source = (tree / module).read_text()
            mutated = mutate_code(source, OPERATORS[name], occurrence)
            number, before, after = changed(source, mutated)
            where = module.relative_to(PACKAGE).as_posix()
            if options.list:
                print(f"{where}:{number}: {before} -> {after}")
                continue
            tests = own_tests(tree, module)
            digest = hashlib.sha256(
                "\0".join(
                    [
                        mutated,
                        *tests,
                        *((tree / test).read_text() for test in tests if test.endswith(".py")),
                    ]
                ).encode()
            ).hexdigest()
            outcome, taken, failed = kept.get(digest, ""), 0.0, ""
            if not outcome:
                limit = 40 + 4 * baseline.get(tuple(tests), 20)
                (tree / module).write_text(mutated)
                outcome, taken, failed = run_tests(tree, tests, limit)
                (tree / module).write_text(source)
                if options.journal:
                    with options.journal.open("a") as journal:
                        journal.write(f"{digest} {outcome}\n")
                if outcome == "passed":
                    baseline[tuple(tests)] = taken
                else:
                    unproven[tuple(tests)] = module
            killed += outcome != "passed"
            print(
                f"{i + 1:4d} {killed:4d} {outcome:8s}{taken:6.1f} s  {where}:{number} {name}: "
                f"{before} -> {after}  {failed}",
                flush=True,
            )
            if outcome == "passed":
                passed[group(module)] += 1
                survivors.append((f"{where}: {before} -> {after}", number))
        # tests that let one mutant pass do pass; those that failed with each may fail without
        for tests in unproven.keys() - baseline.keys():
            outcome, _, failed = run_tests(tree, list(tests), 900)
            if outcome != "passed":
                raise SystemExit(f"{' '.join(tests)} without a mutant: {outcome} {failed}")
    if options.list:
        return 0
    share = killed / len(chosen)
    for name, number in sorted(Counter(group(module) for module, *_ in chosen).items()):
        print(f"{name:20s} {number:4d} mutants, {number - passed[name]:4d} killed")
    print(f"\nseed {options.seed}: {killed} of {len(chosen)} mutants killed, {share:.1%}")
    for mutant, number in survivors:
        print(f"{mutant}  (line {number})\n    {known.get(mutant, 'NO REASON')}")
    return 0 if share >= WANTED and all(mutant in known for mutant, _ in survivors) else 1


if __name__ == "__main__":
    sys.exit(main())

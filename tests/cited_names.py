# SPDX-License-Identifier: BSD-3-Clause
"""Names in `code font` on pages of the manual, and whether the code has them.

What is checked of a code span outside code blocks:

* files of source code, and paths that begin with a folder of the repository: the file is there;
* a name, a call, or the keys of `key = value`: an identifier of the program, or a text without
  spaces in it, such as the name of a result;
* `Class.member` of a class of the program, and `section.key` of a table of the case file.

A page may also use the names of its own code blocks, and of files outside the program that it
names. Names of other programs are in `OTHERS`. Shell commands and formulas are not checked.
Decisions are history: of them only the files are checked.
"""

from __future__ import annotations

import ast
import builtins
import keyword
import pydoc
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from tilth.model.json_schema import case_schema, element_schema

ROOT = Path(__file__).parents[1]
PAGES = sorted(page for page in (ROOT / "docs").glob("**/*.md") if "assets" not in page.parts)
PAGES += [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
PLACES = ("src/", "cpp/", "docs/", "tests/", "examples/", "benchmarks/", ".ci/")
SOURCES = (".py", ".pyi", ".hpp", ".cpp")

OTHERS = {
    "COMMON": "Fortran",
    "MutexInit": "Abaqus",
    "mpiexec": "MPI",
    "NODATA_value": "ESRI ASCII grids",
    "PETSC_DIR": "PETSc",
    "PETSC_OPTIONS": "PETSc",
    "SAVE": "Fortran",
    "cfunc": "numba",
    "codespell": "a program",
    "matstash_reproduce": "PETSc",
    "mpicc": "MPI",
    "srun": "Slurm",
    "vecstash_reproduce": "PETSc",
}
"""Names of other programs and languages, and whose they are."""
STAND_INS = {"CASE", "FILE", "FOLDER", "NAME"}
"""What a reader replaces with a name of his own."""

_WORD = r"[A-Za-z_]\w*"
_NAME = re.compile(rf"{_WORD}(?:\.{_WORD})*")
_CALL = re.compile(rf"({_NAME.pattern})\((.*)\)")
_KEYS = re.compile(rf"(?:\{{ *)?({_NAME.pattern}) = .*")
_KEY = re.compile(rf"({_WORD}) ?=(?!=)")
_SECTION = re.compile(rf"\[+({_NAME.pattern})\]+")
_TEXT = re.compile(r'"[^"]*"')

_END = re.compile(r"_([xyz]{1,2}|mean|von_mises|\d+|NAME)$")
"""Ends that the program puts to a name: components, invariants, numbers, names of the user."""
_DATA = re.compile(r"\.(csv|json|msh|npz|png|pvd|toml|txt|vtkhdf)$")
"""Ends of files that are read or written."""


def spans(text: str) -> list[str]:
    """The code spans of a page outside its code blocks, each on one line."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    return [" ".join(span.split()) for span in re.findall(r"(?<!`)`([^`]+)`(?!`)", text)]


def unknown(text: str, history: bool = False) -> list[str]:
    """The names and files on a page that are not there; of history only files."""
    own = _names_of_page(text)
    wrong = []
    for span in dict.fromkeys(spans(text)):
        files = list(_files(span))
        names = [] if files or history else list(_names(span))
        wrong += [f"`{span}`: no file {name}" for name in files if not _is_file(name, own)]
        wrong += [f"`{span}`: no name {name}" for name in names if not _is_known(name, own)]
    return wrong


def wrong_values(text: str) -> list[str]:
    """The constants of which a page gives another value than the code: `NAME` = 100."""
    given = re.findall(r"`([A-Z][A-Z_0-9]*)` = (\d[\d,]*(?:\.\d+)?(?:e-?\d+)?)", text)
    return [
        f"`{name}` = {value}: in the code {_constants().get(name)}"
        for name, value in given
        if float(value.replace(",", "")) not in _constants().get(name, [])
    ]


@cache
def _constants() -> dict[str, list[float]]:
    """The values of constants of modules, of all that have a name together."""
    found: dict[str, list[float]] = {}
    for node in _nodes():
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            value = node.value.value
            for target in node.targets:
                if isinstance(target, ast.Name) and isinstance(value, int | float):
                    found.setdefault(target.id, []).append(float(value))
    return found


def _files(span: str) -> Iterator[str]:
    """The files of the repository that a span names, also in a command."""
    words = span.split()
    for word in words:
        file = word.partition("::")[0].strip("\"'")
        is_path = len(words) == 1 and file.startswith(PLACES)
        if "*" not in file and (is_path or file.endswith(SOURCES)):
            yield file


def _is_file(name: str, own: set[str]) -> bool:
    """Whether a file of the repository ends so, or the page or the program writes it."""
    end = f"/{name.strip('/')}"
    return any(f"/{path}".endswith(end) for path in _paths()) or name in own | _texts()


def _names(span: str) -> Iterator[str]:
    """The names that a span consists of: one name, that of a call, keys, a section."""
    span = _TEXT.sub('""', span)
    if whole := _NAME.fullmatch(span) or _SECTION.fullmatch(span):
        yield whole.group(whole.lastindex or 0)
    elif call := _CALL.fullmatch(span):
        yield call.group(1)
        yield from _KEY.findall(call.group(2))
    elif keys := _KEYS.fullmatch(span):
        yield keys.group(1)
        yield from _KEY.findall(span)


def _is_known(name: str, own: set[str]) -> bool:
    """Whether a name, perhaps with dots, is one of the program, the page or another program."""
    owner, dot, member = name.rpartition(".")
    owner = owner.rpartition(".")[2]
    if not dot and name.startswith("test_"):
        return name in _tests()
    if name.startswith("tilth."):
        return pydoc.locate(name) is not None or member in own
    if owner in _members():
        return member in _all_members(owner)
    if owner in _sections():
        return member in _sections()[owner] | STAND_INS or _DATA.search(name) is not None
    if {name, name.split(".")[0]} & (own | OTHERS.keys()) or name in _texts() | _paths():
        return True
    parts = _DATA.sub("", name).split(".")
    return all(map(_is_word, parts)) or pydoc.locate(name) is not None


def _is_word(word: str) -> bool:
    """Whether the program has a word, or puts it together."""
    if word in _words() or keyword.iskeyword(word) or hasattr(builtins, word):
        return True
    if word.endswith("_"):
        return all(part in _words() for part in word.strip("_").split("_"))
    start = _END.sub("", word)
    return start == "" or bool({start, f"{start}_"} & (_words() | _abaqus() | STAND_INS))


def _names_of_page(text: str) -> set[str]:
    """Names that a page brings: words of its code blocks, names in files that it names."""
    blocks = re.findall(r"^```[^\n]*\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    found = {word for block in blocks for word in re.findall(r"[\w./]+", block)}
    found |= {word for block in blocks for word in re.findall(_WORD, block)}
    found |= set(re.findall(r"^## \d+\. .*`([^`]+)`$", text, re.MULTILINE))
    for name in spans(text):
        if not name.startswith(("src/", "cpp/")) and (ROOT / name).is_file():
            file = (ROOT / name).read_text(encoding="utf-8", errors="replace")
            found |= set(re.findall(_WORD, file))
    return found


@cache
def _paths() -> set[str]:
    """Files and folders of the repository, from its root."""
    paths = set(ROOT.iterdir())
    for place in PLACES:
        paths |= {ROOT / place, *(ROOT / place).glob("**/*")}
    return {str(path.relative_to(ROOT)) for path in paths}


@cache
def _nodes() -> list[ast.AST]:
    """All parts of the program's Python."""
    files = [*(ROOT / "src").glob("**/*.py"), *(ROOT / "src").glob("**/*.pyi")]
    trees = (ast.parse(file.read_text(encoding="utf-8")) for file in files)
    return [node for tree in trees for node in ast.walk(tree)]


@cache
def _words() -> set[str]:
    """Identifiers of the program and of its build, and words of its texts without spaces."""
    found = {word for text in _texts() for word in re.findall(_WORD, text)}
    for node in _nodes():
        for attribute in ("id", "attr", "name", "arg", "asname"):
            value = getattr(node, attribute, None)
            if isinstance(value, str):
                found.update(value.split("."))
    for file in [*(ROOT / "cpp").glob("**/*.?pp")]:
        code = re.sub(r"//[^\n]*|/\*.*?\*/", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)
        found |= set(re.findall(_WORD, code))
    return found | set(re.findall(_WORD, (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")))


@cache
def _texts() -> set[str]:
    """Texts without spaces in the program, among them parts of those that it puts together."""
    found = {each.value for each in _nodes() if isinstance(each, ast.Constant)}
    return {text for text in found if isinstance(text, str) and re.fullmatch(r"\S+", text)}


@cache
def _abaqus() -> set[str]:
    """Names of the interface of UMATs, as Fortran writes them."""
    files = [ROOT / "cpp/tilth/material/umat.hpp", *(ROOT / "cpp/tilth/abaqus").glob("*.?pp")]
    text = " ".join(file.read_text(encoding="utf-8") for file in files)
    return {word.upper() for word in re.findall(_WORD, text)}


@cache
def _tests() -> set[str]:
    """The names of all tests."""
    files = (ROOT / "tests").glob("**/test_*.py")
    return {
        name
        for file in files
        for name in re.findall(r"def (test_\w+)\(", file.read_text(encoding="utf-8"))
    } | {file.stem for file in (ROOT / "tests").glob("**/test_*.py")}


@cache
def _members() -> dict[str, tuple[set[str], set[str]]]:
    """Members and bases of the classes of the program, of all that have a name together."""
    found: dict[str, tuple[set[str], set[str]]] = {}
    for node in _nodes():
        if isinstance(node, ast.ClassDef):
            members, bases = found.setdefault(node.name, (set(), set()))
            bases.update(ast.unparse(base).rpartition(".")[2] for base in node.bases)
            for each in ast.walk(node):
                if isinstance(each, ast.FunctionDef):
                    members.add(each.name)
                elif isinstance(each, ast.Name | ast.Attribute) and isinstance(each.ctx, ast.Store):
                    members.add(each.id if isinstance(each, ast.Name) else each.attr)
    return found


def _all_members(name: str) -> set[str]:
    """The members of a class and of its bases in the program."""
    members, bases = _members().get(name, (set(), set()))
    return members.union(*(_all_members(base) for base in bases))


@cache
def _sections() -> dict[str, set[str]]:
    """The keys of each table of the case files, by the name of the table."""
    found: dict[str, set[str]] = {}

    for schema in (case_schema(), element_schema()):
        kinds = {f"#/$defs/{name}": kind for name, kind in schema["$defs"].items()}
        for table in [schema, *kinds.values()]:
            for key, value in table.get("properties", {}).items():
                for kind in _kinds_of(value):
                    found.setdefault(key, set()).update(kinds[kind].get("properties", {}))
    return found


def _kinds_of(schema: object) -> set[str]:
    """The kinds of table that a key takes, alone, in a list or by name."""
    if isinstance(schema, dict):
        if "$ref" in schema:
            return {schema["$ref"]}
        return set().union(*(_kinds_of(each) for each in schema.values()))
    if isinstance(schema, list):
        return set().union(*(_kinds_of(each) for each in schema))
    return set()

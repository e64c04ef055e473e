# SPDX-License-Identifier: Apache-2.0
"""
Pages of the repository as pages of the site.

A page of ``docs/`` keeps its place. Whatever else a page links to is shown at ``source/<path>``: Markdown as
it is, other text as a page with the file in it. So every link leads somewhere without a network.
"""

from __future__ import annotations

import os
import re
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from scripts.docs.entity import ROOT

LINK = re.compile(r"(\]\()([^)#\s]*)((?:#[^)\s]*)?[^)]*\))")
NAMED_PAGE = re.compile(r"\[[\w/.]+\.md\](\(([^)#\s]+\.md)[^)]*\))")
DRAWING = re.compile(r"!\[([^\]]*)\]\(([^)\s]*drawing_\w+\.svg)\)")
LANGUAGES = {
    ".py": "python",
    ".vhd": "vhdl",
    ".toml": "toml",
    ".json": "json",
    ".v": "verilog",
    ".sv": "verilog",
    ".sh": "bash",
    ".cpp": "cpp",
}
IMAGES = (".gif", ".png", ".svg", ".jpg")


def place_of(path: PurePosixPath) -> PurePosixPath:
    """
    Where the site shows a file of the repository.

    Parameters
    ----------
    path : PurePosixPath
      Relative to the repository's root.

    Returns
    -------
    PurePosixPath
      Relative to the site's sources.
    """
    if path.parts[0] == "docs" and path.suffix in (".md", *IMAGES):
        return path.relative_to("docs")
    shown = PurePosixPath("source") / path
    return shown if path.suffix in (".md", *IMAGES) else shown.with_name(f"{path.name}.md")


def convert(text: str, path: PurePosixPath, wanted: set[PurePosixPath]) -> str:
    """
    A page's text with the links of the site.

    Parameters
    ----------
    text : str
      Markdown as it stands in the repository.
    path : PurePosixPath
      Its place there.
    wanted : set of PurePosixPath
      Takes the files that it links to.

    Raises
    ------
    FileNotFoundError
      A link leads nowhere.
    """
    here = place_of(path).parent

    def replaced(match: re.Match[str]) -> str:
        start, target, end = match.groups()
        if not target or ":" in target:
            return match[0]
        linked = PurePosixPath(os.path.normpath(path.parent / unquote(target)))
        if (ROOT / linked).is_dir():
            linked /= "README.md"
        wanted.add(linked)
        return f"{start}{os.path.relpath(place_of(linked), here)}{end}"

    text = NAMED_PAGE.sub(lambda found: _titled(found, path.parent), text)
    text = DRAWING.sub(lambda found: _inline(ROOT / path.parent / found[2], found[1]), text)
    return "".join(
        part if is_code else LINK.sub(replaced, part) for is_code, part in _parts(_as_python_markdown(text))
    )


def _titled(link: re.Match[str], folder: PurePosixPath) -> str:
    """A link whose text is a page's file name gets the page's title: the site shows no file names."""
    return f"[{title_of((ROOT / folder / link[2]).read_text())}]{link[1]}"


def _inline(drawing: Path, title: str) -> str:
    """A drawing as part of its page, with the page's font and colours."""
    picture = re.sub(r'<!--.*?-->\n| font-family="[^"]*"', "", drawing.read_text())
    return f'<div class="wide" aria-label="{title}" data-search-exclude>{picture}</div>'


def source_page(path: PurePosixPath) -> str:
    """
    A text file as a page that the search leaves out.

    Raises
    ------
    FileNotFoundError
      It is not there.
    """
    text = (ROOT / path).read_text()
    fence = "`" * 6
    language = LANGUAGES.get(path.suffix, "text")
    head = "---\nsearch:\n  exclude: true\nhide:\n  - toc\n---\n"
    return f'{head}# {path.name}\n\n`{path}`\n\n{fence}{language} linenums="1"\n{text}{fence}\n'


def repository_page(path: PurePosixPath, wanted: set[PurePosixPath]) -> str:
    """A Markdown file as a page of the site; see :func:`convert`. A folder without a README is a list."""
    if path.name == "README.md" and not (ROOT / path).is_file():
        return convert(_folder_page(path.parent), path, wanted)
    text = re.sub(r"\A<!-- SPDX.*?-->\n", "", (ROOT / path).read_text())
    return convert(text, path, wanted)


def _folder_page(folder: PurePosixPath) -> str:
    """What a folder holds: pages by their titles with a link, other files by their names."""
    files = sorted(path for path in (ROOT / folder).iterdir() if path.is_file())
    rows = [
        f"- [{title_of(path.read_text())}]({path.name})" if path.suffix == ".md" else f"- `{path.name}`"
        for path in files
    ]
    return "\n".join([f"# {folder.name.capitalize()}", "", *rows]) + "\n"


def title_of(text: str) -> str:
    """A page's title: its first heading."""
    return re.search(r"^# (.+)$", text, re.MULTILINE)[1].replace("`", "")


def _parts(text: str) -> list[tuple[bool, str]]:
    """A page cut into code (fenced or indented) and the text between."""
    code = re.compile(r"(^```[^\n]*\n.*?^```$|^ {4}[^\n]*$)", re.MULTILINE | re.DOTALL)
    return [(index % 2 == 1, part) for index, part in enumerate(code.split(text))]


def _as_python_markdown(text: str) -> str:
    """
    A blank line before each list and table.

    GitHub lets them follow a paragraph; Python-Markdown, which the site is made with, does not.
    """
    result, fenced = [], False
    for line in text.splitlines():
        fenced ^= line.startswith("```")
        before = result[-1] if result else ""
        goes_on = not before or before.startswith(("- ", "* ", "  ", "|"))
        if not fenced and not goes_on and re.match(r"[-*|] |1\. ", line):
            result.append("")
        result.append(line)
    return "\n".join(result) + "\n"


def write_page(folder: Path, place: PurePosixPath, text: str) -> None:
    """Write a page into the site's sources."""
    (folder / place).parent.mkdir(parents=True, exist_ok=True)
    (folder / place).write_text(text)

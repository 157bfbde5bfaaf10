"""The Python listings of Markdown files, run one by one: `python listings.py README.md`, as a newcomer pastes them."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple


#: Packages that a listing may use and that need not be there.
OPTIONAL = {"gymnasium", "jax", "ray", "torch"}


def is_of_optional(error: ImportError) -> bool:
    """Whether a listing failed since an optional package, or part of this one, is not installed."""
    name = error.name or ""
    return name == "dualbody.cuda" or name.split(".")[0] in OPTIONAL


class Listing(NamedTuple):
    """A block of code of a file, and the line of its first statement."""

    path: Path
    line: int
    text: str

    def run(self) -> None:
        """Runs the listing by itself; a traceback names the line of the file."""
        source = "\n" * (self.line - 1) + self.text
        exec(compile(source, str(self.path), "exec"), {"__name__": "__main__"})


def listings(path: Path) -> Iterator[Listing]:
    """The blocks of a Markdown file that are marked as Python."""
    lines = path.read_text(encoding="utf-8").splitlines()
    first = None
    for k, line in enumerate(lines):
        if first is None and line.strip() == "```python":
            first = k + 1
        elif first is not None and line.strip() == "```":
            yield Listing(path, first + 1, "\n".join(lines[first:k]) + "\n")
            first = None


def main() -> None:
    """Runs the listings of all files that are named, in an empty folder."""
    found = [listing for name in sys.argv[1:] for listing in listings(Path(name).resolve())]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for listing in found:
            print(f"{listing.path}:{listing.line}", flush=True)
            try:
                listing.run()
            except ImportError as error:
                if not is_of_optional(error):
                    raise
                print(f"left out: {error}")
        os.chdir("/")
    if not found:
        sys.exit("no listing in Python")


if __name__ == "__main__":
    main()

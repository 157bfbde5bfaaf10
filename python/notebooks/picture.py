"""Writes a page of the executed notebook, from which `tests/browser/notebook.mjs` takes the picture of python/README.md.

    pip install nbclient nbconvert ipykernel ./python
    python python/notebooks/picture.py && bash tests/browser/install.sh && node tests/browser/notebook.mjs
"""

from __future__ import annotations

from pathlib import Path

import nbclient
import nbconvert
import nbformat

FOLDER = Path(__file__).resolve().parent
OUT = FOLDER.parents[1] / "out" / "notebook"


def main() -> None:
    notebook = nbformat.read(FOLDER / "closed_loop_controllers.ipynb", as_version=4)
    resources = {"metadata": {"path": str(FOLDER)}}
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=resources).execute()
    page, _ = nbconvert.HTMLExporter().from_notebook_node(notebook)
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "index.html").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()

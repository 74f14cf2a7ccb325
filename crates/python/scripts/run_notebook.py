"""Executes a notebook; its last state goes nowhere. An exception in a cell is one here.

python scripts/run_notebook.py NOTEBOOK [OUTPUT]
"""

from __future__ import annotations

import sys

import nbformat
from nbclient import NotebookClient


def main() -> None:
    notebook = nbformat.read(sys.argv[1], as_version=4)
    NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    if len(sys.argv) > 2:
        nbformat.write(notebook, sys.argv[2])
    print(f"{sys.argv[1]}: {sum(cell.cell_type == 'code' for cell in notebook.cells)} cells")


if __name__ == "__main__":
    main()

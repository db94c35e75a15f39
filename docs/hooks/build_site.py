"""What MkDocs calls while it builds the site: pages from the code, pictures, notebooks.

A page of the tutorials or of machines is run once, in a folder of its own; the files that it
makes and shows are those of the site. ``DOCS_FOLDER`` names a folder in which pages were run
already.
"""

from __future__ import annotations

import os
import tempfile
from hashlib import sha256
from pathlib import Path, PurePosixPath

from code_blocks import code_blocks, produced, run_page
from formulas import with_formulas
from generated_pages import (
    api_pages,
    command_pages,
    copied_pages,
    exit_code_page,
    gallery_pages,
    json_pages,
)
from mkdocs.structure.files import File
from notebooks import IN_PYTHON, notebook, notebook_page
from output_lines import with_wrapped_lines

MAKERS = ("tutorials", "machines", IN_PYTHON)  # folders whose pages make files that they show
PAGES = (api_pages, command_pages, copied_pages, exit_code_page, gallery_pages, json_pages)


def on_config(config):
    """List the pages of the Python API in the navigation."""
    api = [{_title(text): path} for path, text in api_pages().items()]
    for section in config.nav:
        for entry in section.get("Reference", ()):
            if "Python" in entry:
                entry["Python"] = api
    return config


def _title(text):
    return text.splitlines()[0].removeprefix("# ")


def on_files(files, config):
    """Add the pages that are made from the code, and the files that pages make."""
    for make in PAGES:
        for path, text in make().items():
            files.append(File.generated(config, path, content=text))
    for file in [file for file in files if Path(file.src_uri).parent.name in MAKERS]:
        if file.is_documentation_page():
            _add_made_files(file, files, config)
    return files


def _add_made_files(file, files, config):
    """Add the files that a page makes and shows, and the notebook of a tutorial."""
    name, maker = file.src_uri.removesuffix(".md"), Path(file.src_uri).parent
    text, beside = file.content_string, Path(file.abs_src_path).parent
    if not _is_run(text):
        return
    if maker.name == IN_PYTHON or _is_own_notebook(file.src_uri, files):
        book = notebook(text)
        files.append(File.generated(config, f"{name}.ipynb", content=book))
    made = produced(text, _folder(name, text, beside))
    for shown, path in made.items():
        uri = f"{maker.as_posix()}/{shown}"
        if (beside / shown).is_file():
            continue
        if files.get_file_from_path(uri):
            raise ValueError(f"{file.src_uri}: another page makes {shown} too")
        files.append(File.generated(config, uri, abs_src_path=str(path)))


def _is_own_notebook(uri, files):
    """Whether a page is a tutorial whose blocks are its notebook."""
    page = PurePosixPath(uri)
    return page.parent.name == "tutorials" and notebook_page(page, files.src_uris) == page


def _is_run(text):
    """Whether a page has blocks that run."""
    return any(not block.reason for block in code_blocks(text))


def _folder(name, text, beside):
    """Run a page, unless its folder is there, and return the folder."""
    digest = sha256(text.encode()).hexdigest()  # `mkdocs serve` builds again and again
    made = os.environ.get("DOCS_FOLDER")
    folder = Path(made) / name if made else Path(_TEMPORARY.name) / name / digest
    if not folder.exists():
        folder.mkdir(parents=True)
        run_page(text, folder, beside)
    return folder


_TEMPORARY = tempfile.TemporaryDirectory(prefix="docs-")


def on_page_markdown(markdown, page, files, **_):
    """Offer the notebook of a tutorial."""
    name = PurePosixPath(page.file.src_uri)
    if name.parent.name not in ("tutorials", IN_PYTHON) or not _is_run(markdown):
        return markdown
    if name.parent.name == IN_PYTHON or _is_own_notebook(name.as_posix(), files):
        return f"{markdown}\n\n[This page as a notebook]({name.stem}.ipynb)\n"
    other = f"../{IN_PYTHON}/{name.stem}"
    return f"{markdown}\n\n[The same in Python]({other}.md), [as a notebook]({other}.ipynb)\n"


def on_page_content(html, **_):
    """Draw formulas, and let what was printed wrap."""
    return with_wrapped_lines(with_formulas(html))

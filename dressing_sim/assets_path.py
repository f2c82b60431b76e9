"""Where the files are that people may want to edit: ``assets/`` of the project."""

from pathlib import Path


def assets() -> Path:
    """The assets folder: inside the installed package, or at the top of a source checkout."""
    package = Path(__file__).resolve().parent
    installed = package / "assets"
    return installed if installed.is_dir() else package.parent / "assets"

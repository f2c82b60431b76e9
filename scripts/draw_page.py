"""Draws docs/view.png: the page in a headless Chromium, in the middle of a dressing.

python scripts/draw_page.py [FILE]
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from chromium import Chromium

from dressing_sim.viewer.app import Page
from dressing_sim.viewer.lessons import Lessons
from dressing_sim.viewer.session import Session

#: Longest that anything may take [s].
LONG = 600.0

#: Where the arm coordinate of the sleeve's end is in the picture: just past the elbow.
AT = 1.3


def main(file: Path) -> None:
    """Dress the first arm until the sleeve is past the elbow, and take a picture."""
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        session = Session(Lessons(Path(folder) / "takes.h5"))
        session.set_speed(0.0)
        page, browser = Page(session, port=0), Chromium(Path(folder))
        try:
            tab = browser.open(f"http://127.0.0.1:{page.port}")
            tab.says("Dress", LONG)
            page.wait_for_robot(LONG)
            tab.press("Dress", LONG)
            past = session.wait(
                lambda: any(moment.row.armscye_s > AT for moment in session.moments()[-1:]), LONG
            )
            assert past, session.error
            session.pause()
            page.wait_for_likeness(LONG)
            page.wait_until_drawn(LONG)
            tab.says("time stands still", LONG)
            tab.settle()
            tab.picture(file)
        finally:
            browser.close()
            page.close()


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/view.png"))

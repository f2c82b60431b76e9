"""``dressing-sim view``: the page in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from dressing_sim.errors import InvalidInputError

#: Where only this machine can connect.
LOOPBACK = "127.0.0.1"


def view(
    run: Annotated[Path | None, tyro.conf.Positional] = None,
    port: int = 8080,
    host: str = LOOPBACK,
    takes: Path = Path("takes.h5"),
) -> None:
    """Open a page in the browser: bend the arm, watch a policy dress it, teach one yourself.

    For example: dressing-sim view

    Or, to look at what was measured: dressing-sim view results/evaluate --port 8090

    Whoever can reach the page can use it: other machines cannot, unless --host says so.

    Args:
        run: a run's folder, that ``dressing-sim evaluate`` left.
        port: to listen at; 0 for any that is free.
        host: address to listen at; 0.0.0.0 for all of this machine's.
        takes: file that demonstrations by hand are kept in, and learned from.
    """
    import logging
    import time

    from dressing_sim.extras import needed
    from dressing_sim.files import check_writable
    from dressing_sim.viewer.app import Page, check_port
    from dressing_sim.viewer.lessons import Lessons
    from dressing_sim.viewer.past import Past
    from dressing_sim.viewer.session import Session

    needed("viser", "view")
    check_port(host, port)
    if takes.suffix not in (".h5", ".hdf5"):
        raise InvalidInputError(f"takes {takes}: valid is a file whose name ends in .h5")
    check_writable(takes)
    # Browsers open connections that they then do not use.
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
    session = Session(Lessons(takes), past=None if run is None else Past(run))
    page = Page(session, host, port)
    shown = "localhost" if host == LOOPBACK else host
    print(f"the page is at http://{shown}:{page.port} (Ctrl-C ends it)", flush=True)
    try:
        while True:
            time.sleep(1.0)
    finally:
        page.close()

r"""Walking through a solution in a browser.

    Solution, LitModel --layers--> Lit --packet--> bytes --page--> one file that works offline
                                                       \--server--> a browser beside this process

The page is a single HTML file that ``make viewer`` builds from ``viewer/`` (TypeScript, three.js). It knows nothing of
how light is found: it is given packets (:mod:`packet`), and where a server is behind it, they and messages
(:mod:`messages`) go both ways over one websocket. The server (:mod:`server`) guards; the session behind it
(:mod:`session`) solves and relights in one thread of its own, so that nothing waits for light.
"""

from __future__ import annotations

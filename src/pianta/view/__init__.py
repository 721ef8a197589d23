"""The page of `pianta view`: floors over their maps in a browser, to look at, and to correct.

Needs the extra `web`. The server listens on the loopback address only, and the page loads nothing from elsewhere.
"""

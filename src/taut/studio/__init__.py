"""The browser studio: a page that draws scenes and shows plans, and the server and workers that plan for it.

The page holds the document; the server keeps nothing but the name of the one file it may write; the work is done in
processes of their own, so that neither page nor server ever waits for it.
"""

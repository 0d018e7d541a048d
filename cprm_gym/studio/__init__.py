"""The studio: one local page in which a run, its nets and its beliefs are watched, stopped and asked, and nets and models are edited.

``cprm-gym studio`` starts a web server of its own (`server`), whose page is plain ES modules and SVG (`static`). The page and the server
speak over one websocket, in JSON texts:

==================  =====================================================================================================
page to server      ``{"id": 7, "call": "watch.step", "with": {"cycles": 1}}``
answer              ``{"re": 7, "result": ...}``, or ``{"re": 7, "error": "what is wrong", "kind": "ParameterError"}``
server to page      ``{"event": "frame", ...}``: something has happened, asked for or not
==================  =====================================================================================================

A call is the name of a room and of a function in it (`calls.Calls`). Calls of one room are answered in the order in which they come,
each room in a thread of its own, so that a long one in ``run`` does not keep ``watch`` waiting. What a call does wrong is answered, not
raised: the connection stays.
"""

"""``ETag`` and ``If-Match`` (RFC 9110): of two editors of one thing, the second does not overwrite the first unseen.

How a router uses them::

    @router.get("/things/{id}", response_model=Thing, responses=with_etag(problems(404)))
    async def get_thing(id: str) -> Response:
        return tagged(thing)                        # the answer, with the header ETag

    @router.put("/things/{id}", response_model=Thing, responses=with_etag(problems(404, 412, 422)))
    async def replace_thing(id: str, new: NewThing, if_match: IfMatch = None) -> Response:
        async with one:                             # an asyncio.Lock: nothing may come between check and change
            check_match(if_match, find(id))         # raises Problem 412 when it is another version by now
            return tagged(await replace(id, new))

A tag is a hash of what an editor can change: ``version`` where the record holds more than that (a measured pose), else
the whole record. So it is the same after a restart, and a change that is taken back is none. A list carries the tag of
each item as a member ``etag``, so that an item can be changed without another GET. A request without ``If-Match`` is
done on what there is: a script need not ask first.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import Header

from app.console.problems import Problem
from app.console.rest.answers import Json
from app.console.wire import etag

__all__ = ["IfMatch", "check_match", "etag", "tagged", "with_etag"]

#: The parameter of a route that changes something: the header ``If-Match``, None where it was left out.
IfMatch = Annotated[
    str | None,
    Header(
        alias="If-Match",
        description="The `ETag` of the version that the change is meant for; if there is another by now, the answer is "
        "412 and nothing is changed. Left out, or `*`: any version.",
        json_schema_extra={"examples": ['"5d41402abc4b2a76"']},
    ),
]

#: A list of entity tags, weak ones among them.
_TAGS = re.compile(r'\s*(?:(?:W/)?"[\x21\x23-\x7e\x80-\xff]*"\s*(?:,\s*|$))+')
_TAG = re.compile(r'(W/)?"([\x21\x23-\x7e\x80-\xff]*)"')


def tagged(record: Any, *, version: Any = None, status: int = 200, headers: Mapping[str, str] | None = None) -> Json:
    """The answer ``record`` with the tag of ``version``; None: of the record itself."""
    tag = etag(record if version is None else version)
    return Json(record, status_code=status, headers={**(headers or {}), "ETag": tag})


def check_match(if_match: str | None, version: Any) -> None:
    """Raises Problem 412, with the present tag as its ``ETag``, where ``if_match`` names other versions than
    ``version``; 422 where it is no list of tags. None and ``*`` match any."""
    if if_match is None or if_match.strip() == "*":
        return
    if not _TAGS.fullmatch(if_match):
        message = 'should be one or more quoted entity tags, such as "5d41402abc4b2a76", or *'
        raise Problem(422, "invalid-request", f"If-Match {message}.", errors=[("header.If-Match", message)])
    now = etag(version)
    # Compared strongly: a weak tag matches nothing.
    if now not in {f'"{tag}"' for weak, tag in _TAG.findall(if_match) if not weak}:
        raise Problem(
            412,
            "changed-meanwhile",
            "It was changed since you read it, and nothing was done: read it again, and make the change on that.",
            headers={"ETag": now},
        )


def with_etag(responses: Mapping[int | str, dict[str, Any]], status: int = 200) -> dict[int | str, dict[str, Any]]:
    """OpenAPI's description of ``responses`` and of the header ``ETag`` of the answer ``status``."""
    header = {"ETag": {"schema": {"type": "string"}, "description": "Its version, for `If-Match`."}}
    answer = responses.get(status, {})
    return {**responses, status: {**answer, "headers": {**answer.get("headers", {}), **header}}}

"""ETag and If-Match: what matches, what is refused, and what is no list of tags."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from app.console.problems import Problem
from app.console.rest.answers import problems
from app.console.rest.entity_tags import check_match, etag, tagged, with_etag


@dataclass(frozen=True)
class Thing:
    name: str
    measured_m: float


ARM, LEG = Thing("arm", 1.0), Thing("leg", 1.0)


def test_a_tag_is_of_the_content_alone() -> None:
    assert etag(ARM) == etag(Thing("arm", 1.0)) != etag(LEG)
    assert etag(ARM).startswith('"')
    assert etag(ARM).endswith('"')
    assert len(etag(ARM)) == 18


def test_an_answer_carries_its_tag_and_may_leave_measurements_out_of_it() -> None:
    assert tagged(ARM).headers["ETag"] == etag(ARM)
    moved = tagged(Thing("arm", 1.1), version="arm", status=201, headers={"Location": "/things/arm"})
    assert moved.headers["ETag"] == tagged(ARM, version="arm").headers["ETag"]
    assert (moved.status_code, moved.headers["Location"]) == (201, "/things/arm")


@pytest.mark.parametrize(
    "header", [None, "*", " * ", etag(ARM), f'"other", {etag(ARM)}', f'{etag(ARM)} , W/"weak"', f"{etag(ARM)},"]
)
def test_the_version_that_is_named_may_be_changed(header: str | None) -> None:
    check_match(header, ARM)


@pytest.mark.parametrize("header", [etag(LEG), f"W/{etag(ARM)}", '"a", "b"', '""'])
def test_another_version_is_refused_with_the_present_tag(header: str) -> None:
    with pytest.raises(Problem) as refused:
        check_match(header, ARM)
    assert (refused.value.status, refused.value.kind) == (412, "changed-meanwhile")
    assert refused.value.headers == {"ETag": etag(ARM)}


@pytest.mark.parametrize(
    "header", ["", "arm", etag(ARM).strip('"'), f"{etag(ARM)} {etag(ARM)}", '"a', '"a"b', ",", "*,*"]
)
def test_what_is_no_tag_is_refused_by_name(header: str) -> None:
    with pytest.raises(Problem) as refused:
        check_match(header, ARM)
    assert refused.value.status == 422
    assert [fault.field for fault in refused.value.errors] == ["header.If-Match"]


def test_the_description_says_which_answer_has_a_tag() -> None:
    described = with_etag({201: {"headers": {"Location": {}}}, **problems(412)}, 201)
    assert set(described[201]["headers"]) == {"Location", "ETag"}
    assert "If-Match" in described[412]["description"]

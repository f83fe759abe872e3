"""Every refusal as a problem document (RFC 9457, ``application/problem+json``)."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any, get_args

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.routing import compile_path

from app.attention.desires import InvalidDesire, UnknownDesireClass
from app.attention.workspace import UnknownDesire
from app.base.broken_rule import Rule, broken_rule
from app.base.yaml_source import validation_message
from app.console.wire import encode

MEDIA_TYPE = "application/problem+json"
_MISTAKE = "The console made a mistake, which its log describes; the request may or may not have been done."


class FieldProblem(BaseModel):
    """The error in one field."""

    field: str = Field(description="Dotted path of the field: `params.rate`, `query.limit`.")
    message: str = Field(description="What is allowed there.")
    kind: str = Field(
        default="", description="The rule that the value breaks, as `greater_than`: for other languages. Empty: none."
    )
    values: dict[str, str | float] = Field(
        default={}, description='What `kind` says, as `{"gt": 0}`, and the value that was `given`.'
    )


class ProblemDocument(BaseModel, extra="allow"):
    """A refusal (RFC 9457)."""

    type: str = Field(description="The kind of problem: `urn:hbba:problem:` and a stable name.")
    title: str = Field(description="The kind of problem in words.")
    status: int = Field(description="The HTTP status.")
    detail: str = Field(description="What happened this time, and what is allowed.")
    errors: list[FieldProblem] = Field(default=[], description="Field by field, where fields are wrong.")


@dataclass(frozen=True, slots=True)
class FieldFault:
    """What is wrong with one field, in words; ``rule``: the rule of the request's model that it breaks, if any."""

    field: str
    message: str
    rule: Rule | None = None


class Problem(Exception):
    """Ends a request with a problem document.

    ``kind`` is the last part of its type, ``errors`` are faults, or pairs of field and message, ``more`` further
    members.
    """

    def __init__(
        self,
        status: int,
        kind: str,
        detail: str,
        *,
        errors: Iterable[tuple[str, str] | FieldFault] = (),
        headers: dict[str, str] | None = None,
        **more: Any,
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.kind = kind
        self.detail = detail
        self.errors = [each if isinstance(each, FieldFault) else FieldFault(*each) for each in errors]
        self.headers = headers or {}
        self.more = more


def problem_body(problem: Problem) -> bytes:
    document: dict[str, Any] = {
        "type": f"urn:hbba:problem:{problem.kind}",
        "title": _title(problem),
        "status": problem.status,
        "detail": problem.detail,
    }
    if problem.errors:
        document["errors"] = [_error(fault) for fault in problem.errors]
    return encode(document | problem.more)


def _error(fault: FieldFault) -> dict[str, Any]:
    said = {"field": fault.field, "message": fault.message}
    return said if fault.rule is None else said | {"kind": fault.rule.kind, "values": dict(fault.rule.values)}


def problem_response(problem: Problem) -> Response:
    return Response(problem_body(problem), problem.status, headers=problem.headers, media_type=MEDIA_TYPE)


def _title(problem: Problem) -> str:
    words = problem.kind.replace("-", " ")
    return words[0].upper() + words[1:]


def install_problem_handlers(app: FastAPI) -> None:
    """Turn every exception that a person's request can cause into a problem document."""

    @app.exception_handler(Problem)
    async def on_problem(_: Request, problem: Problem) -> Response:
        return problem_response(problem)

    @app.exception_handler(UnknownDesireClass)
    async def on_unknown_class(_: Request, error: UnknownDesireClass) -> Response:
        return problem_response(
            Problem(422, "unknown-desire-class", str(error), errors=[("class", str(error))], known=list(error.known))
        )

    @app.exception_handler(InvalidDesire)
    async def on_invalid_desire(_: Request, error: InvalidDesire) -> Response:
        fault = FieldFault(error.field, error.message, error.rule)
        return problem_response(Problem(422, "invalid-desire", str(error), errors=[fault]))

    @app.exception_handler(UnknownDesire)
    async def on_unknown_desire(_: Request, error: UnknownDesire) -> Response:
        return problem_response(Problem(404, "no-such-desire", str(error)))

    @app.exception_handler(RequestValidationError)
    async def on_validation(request: Request, error: RequestValidationError) -> Response:
        return problem_response(_validation_problem(error, _body_model(request)))

    @app.exception_handler(HTTPException)
    async def on_http(request: Request, error: HTTPException) -> Response:
        headers = dict(error.headers or {})
        if error.status_code == 404:
            problem = Problem(404, "not-found", f"There is nothing at {request.url.path}.", headers=headers)
        elif error.status_code == 405:
            allowed = ", ".join(await _methods(request)) or "GET"
            detail = f"{request.url.path} takes {allowed}, not {request.method}."
            problem = Problem(405, "method-not-allowed", detail, headers={"Allow": allowed})
        else:
            kind = HTTPStatus(error.status_code).phrase.lower().replace(" ", "-")
            problem = Problem(error.status_code, kind, str(error.detail), headers=headers)
        return problem_response(problem)

    @app.exception_handler(Exception)
    async def on_mistake(_: Request, __: Exception) -> Response:
        # Starlette raises it again once this is sent, so that the server logs it.
        return problem_response(Problem(500, "mistake-of-ours", _MISTAKE))


async def _methods(request: Request) -> list[str]:
    """Every method that the requested path takes; Starlette names only those of the first route it finds."""
    paths = (await asyncio.to_thread(request.app.openapi))["paths"]
    # OpenAPI: a path without names in it goes before those with, whatever else would match.
    of_path = [paths[request.url.path]] if request.url.path in paths else []
    matching = of_path or [each for path, each in paths.items() if compile_path(path)[0].match(request.url.path)]
    return sorted({method.upper() for operations in matching for method in operations})


def _validation_problem(error: RequestValidationError, model: type[BaseModel] | None) -> Problem:
    details = error.errors()
    if details and details[0]["type"] == "json_invalid":
        position = details[0]["loc"][-1]
        reason = details[0].get("ctx", {}).get("error", "it cannot be read")
        return Problem(400, "malformed-json", f"The body is not JSON: {reason} (character {position}).")
    if details and details[0]["loc"] == ("body",):
        message = "should be a JSON object, sent with the header Content-Type: application/json"
        return Problem(422, "invalid-request", f"The body {message}.", errors=[("body", message)])
    errors = [FieldFault(_field(detail["loc"]), _message(detail, model), broken_rule(detail)) for detail in details]
    listed = "; ".join(f"{fault.field}: {fault.message}" for fault in errors)
    return Problem(422, "invalid-request", listed, errors=errors)


def _body_model(request: Request) -> type[BaseModel] | None:
    """The model of the body of ``request``, where its route takes one."""
    field = getattr(request.scope.get("route"), "body_field", None)
    kinds = [] if field is None else [field.field_info.annotation, *get_args(field.field_info.annotation)]
    return next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)), None)


def _message(detail: Any, model: type[BaseModel] | None) -> str:
    where = detail["loc"]
    if where and where[0] == "body":
        detail = {**detail, "loc": where[1:]}
    else:
        model = None
    return validation_message(model, detail, "a JSON object")


def _field(location: tuple[int | str, ...]) -> str:
    # FastAPI begins a location with where the value stood; for a body that goes without saying.
    parts = location[1:] if location and location[0] == "body" and len(location) > 1 else location
    return ".".join(str(part) for part in parts)

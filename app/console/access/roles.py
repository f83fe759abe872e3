"""Roles: who may do what. One table says which role each route and each message of a page needs.

A spectator sees everything and changes nothing, but may stop the robot. An operator drives and edits. A supervisor may
take the wheel at once, release another's emergency stop, and replace or delete what is kept. A route without a role
cannot be made, and a test walks over all routes and messages.
"""

from __future__ import annotations

import enum


class Role(enum.StrEnum):
    """What a person who has logged in may do: each role may do what those before it may."""

    SPECTATOR = "spectator"
    OPERATOR = "operator"
    SUPERVISOR = "supervisor"

    def covers(self, needed: Role) -> bool:
        """Whether this role may do what ``needed`` may."""
        return _RANK[self] >= _RANK[needed]


_RANK = {role: rank for rank, role in enumerate(Role)}


def _table(**roles: str) -> dict[str, Role]:
    return {name: Role(role) for role, names in roles.items() for name in names.split()}


#: Operations of REST that need no login: they are the logins themselves, and the sign of life.
OPEN_OPERATIONS = frozenset({"get_session", "log_in", "log_out", "get_health", "check_visitor", "enter_as_visitor"})

#: The role that each other operation of REST needs. What is below ``/visitor`` visitors may do by the key of their run.
OPERATIONS: dict[str, Role] = _table(
    spectator="""
        latch_e_stop
        get_robot get_fleet get_percepts list_modules get_module list_channels list_viewers get_scene
        list_desires get_desire list_desire_classes get_desire_class
        get_intention list_strategies list_rules get_emotions list_resources get_timeline get_link get_lanes
        find_camera_point find_scene_point get_goal plan_route
        list_maps get_map get_map_picture get_zones list_places get_place
        get_playback list_recordings download_recording
        get_rehearsal get_memory get_tour_run list_tour_reports export_tour_reports get_tour_report
        list_tours validate_tour get_tour_schema get_tour export_tour export_tour_archive get_tour_posters
        list_tour_media get_tour_media get_visitor_media
    """,
    operator="""
        release_e_stop
        create_desire change_desire remove_desire change_resource ask_what_if
        set_goal cancel_goal place_robot search_robot set_zones
        create_place replace_place change_place delete_place
        change_playback step_playback
        start_recording stop_recording save_ring replay_recording end_replay
        start_rehearsal cancel_rehearsal start_tour press_tour dismiss_tour
        create_tour import_tour replace_tour change_tour undo_tour redo_tour
        add_tour_media delete_tour_media
        get_visitor_link press_as_visitor
    """,
    supervisor="""
        save_map load_map rename_map delete_map begin_map
        delete_recording delete_tour delete_tour_report put_link
        delete_memory delete_episode
        list_webhooks get_webhook create_webhook try_webhook delete_webhook
    """,
)


def needed_role(operation: str) -> Role | None:
    """The role that an operation of REST needs; None: no login. Raises KeyError for one that is not in the table."""
    return None if operation in OPEN_OPERATIONS else OPERATIONS[operation]


#: The role that each message of a page on the live stream needs, by its ``type``; ``voice`` is a frame of speech.
MESSAGES: dict[str, Role] = _table(
    spectator="e_stop ping ack view listen",
    operator="drive look clear_e_stop ask_control answer_control release_control voice",
    supervisor="take_control",
)

#: The role that each WebSocket needs, by its path. The face's shows the key for visitors.
SOCKETS: dict[str, Role] = _table(
    spectator="/api/v1/live /api/v1/visitor/live /viser /viser/pulse",
    operator="/api/v1/face",
)

_ARTICLES = {Role.SPECTATOR: "a spectator", Role.OPERATOR: "an operator", Role.SUPERVISOR: "a supervisor"}


def in_words(role: Role) -> str:
    """``a spectator``."""
    return _ARTICLES[role]

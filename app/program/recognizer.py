"""What recognizes words in a program."""

from __future__ import annotations

from app.program.config import Configuration
from app.runtime.graph import load_class
from app.speech.recognition import RecognizerConfig

_SETTING = "recognizer"


def recognizer_of(configuration: Configuration) -> RecognizerConfig | None:
    """The recognizer of the first module that has one; None: no module does. Raises ConfigError."""
    for spec in configuration.program.modules.values():
        module_class = load_class(spec.class_path)
        field = None if module_class is None else module_class.Settings.model_fields.get(_SETTING)
        if field is not None and field.annotation is RecognizerConfig:
            return RecognizerConfig.model_validate(spec.settings.get(_SETTING, {}))
    return None

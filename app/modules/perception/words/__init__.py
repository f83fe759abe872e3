"""Words: endpointing of utterances, and the beam that hears one utterance by all microphones."""

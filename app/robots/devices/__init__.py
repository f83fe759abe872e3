"""A body of this computer's own devices: a camera and microphones, or files in their place; nothing that moves."""

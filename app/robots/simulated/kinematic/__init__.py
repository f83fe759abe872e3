"""A body on a saved map, without physics, pictures and sound: cheap enough to be played many times faster than life."""

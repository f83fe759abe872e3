"""Goals in the lab among people, one after another, unattended."""

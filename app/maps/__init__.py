"""Maps on disk: their folder, their files, and the service of the module that makes them."""

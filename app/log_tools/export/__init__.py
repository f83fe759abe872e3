"""Messages of a log as files for other programs: pictures, video, tables, sound, point clouds; one file per format."""

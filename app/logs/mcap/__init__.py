"""Recordings as MCAP files: layout, writer, ring of the last minutes, reader, bounds."""

"""Tools on logs: repair of damaged recordings, cutting, export to other formats."""

"""From sensor messages to percepts: pure algorithm files beside thin modules."""

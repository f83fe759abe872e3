"""The parts of a robot as they are on its wires: a base's firmware and a laser, byte for byte."""

"""A simulated body in a simulated laboratory: MuJoCo, sensors and guard in a process of their own."""

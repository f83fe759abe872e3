"""From behaviors' commands to the motors: arbitration and limits."""

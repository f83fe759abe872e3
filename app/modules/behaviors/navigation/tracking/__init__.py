"""Path tracking: controllers, the control cycle and its sensor checks."""

"""The closed-loop experiment: wrong costs, dearer modules, a computer that is taken away, without the loop and with it."""

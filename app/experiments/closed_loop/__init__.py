"""The closed-loop experiment: wrong costs, a dear module, half of the computer gone; without the loop and with it."""

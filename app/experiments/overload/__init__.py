"""What falls behind without attention on a computer that is too small, and what attention keeps (thesis 4.4.2)."""

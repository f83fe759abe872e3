"""The guide of tours as pure functions: what it sees in, what it desires out."""

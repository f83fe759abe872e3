"""The motivation that remembers episodes, recognizes them and anticipates what comes next."""

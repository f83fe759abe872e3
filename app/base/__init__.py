"""What every room uses: geometry, errors, files of unknown origin, compiled kernels, child processes, logging."""

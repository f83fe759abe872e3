"""What the program costs, measured beside what others use for the same: ``python -m benchmarks.<name>``.

Contenders run interleaved in the same process and the same minute, since on a shared computer a figure taken alone
says little. Every benchmark gives the rows of ``benchmarks.report``.
"""

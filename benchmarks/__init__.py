"""Cost of the program, measured beside other software for the same purpose: ``python -m benchmarks.<name>``.

Contenders run interleaved in the same process and the same minute, since on a shared computer a figure taken alone says
little. Every benchmark gives the rows of ``benchmarks.report``.
"""

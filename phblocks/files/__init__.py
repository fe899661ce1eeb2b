"""Runs on disk: written while they go on, resumed after a kill, read with or without the system.

A run is an HDF5 file, ``run.h5``. While it is written it is a folder beside it, ``run.h5.parts``, of chunks: small
HDF5 files, each complete before it gets its name, and never changed afterwards. HDF5 itself promises nothing to a file
that is open when its process is killed, and crashes the interpreter on a full disk; so it is never told of errors here.
"""
